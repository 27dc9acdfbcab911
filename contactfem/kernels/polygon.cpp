// Which parts of two surfaces in space see each other, and the integrals over them.
#include "polygon.hpp"
#include "kernels.h"
#include <vector>

namespace {

using namespace polygon;

struct Piece { // what a nonmortar triangle shares with one mortar triangle
  int64_t pair;
  int other; // triangle of the mortar facet
  Polygon polygon;
  Window window;
  Point centre;
  double distance;
  bool visible;
};

// Of the polygon's area, and how far the mortar triangle is above the plane there.
void locate(Piece &piece) {
  const Polygon &p = piece.polygon;
  double area = 0.0, u = 0.0, v = 0.0, height = 0.0, value[3];
  for (int t = 1; t + 1 < p.n; ++t) {
    const double a = cross(p.p[0], p.p[t], p.p[t + 1]) / 3.0;
    area += 3.0 * a;
    u += a * (p.p[0].u + p.p[t].u + p.p[t + 1].u);
    v += a * (p.p[0].v + p.p[t].v + p.p[t + 1].v);
  }
  piece.centre = area > 0.0 ? Point{u / area, v / area} : p.p[0];
  Shape(piece.window.p).at(piece.centre, value);
  for (int w = 0; w < 3; ++w)
    height += value[w] * piece.window.height[w];
  piece.distance = std::abs(height);
}

bool contains(const Polygon &polygon, const Point &p) {
  for (int i = 0; i < polygon.n; ++i)
    if (!(cross(polygon.p[i], polygon.p[(i + 1) % polygon.n], p) > 0.0))
      return false;
  return true;
}

// Hides every piece whose centre is behind a nearer one that is visible. Neighbours on a surface
// share no place in the plane, so only surfaces one behind the other are told apart.
void look(std::vector<Piece> &pieces, std::vector<std::size_t> &order) {
  order.resize(pieces.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = i;
  for (Piece &piece : pieces)
    locate(piece);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return pieces[a].distance < pieces[b].distance ||
           (pieces[a].distance == pieces[b].distance && a < b);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    Piece &piece = pieces[order[i]];
    piece.visible = true;
    for (std::size_t k = 0; k < i && piece.visible; ++k) {
      const Piece &nearer = pieces[order[k]];
      piece.visible = !(nearer.visible && contains(nearer.polygon, piece.centre));
    }
  }
}

// All pieces of one nonmortar triangle with the mortar facets of some pairs.
void gather(const std::vector<Facet> &others, const int64_t first, const Plane &plane,
            std::vector<Piece> &pieces) {
  pieces.clear();
  Polygon polygon;
  for (std::size_t f = 0; f < others.size(); ++f)
    for (int j = 0; j < others[f].triangles; ++j) {
      const Window window(others[f], j, plane);
      if (intersect(plane, window, polygon))
        pieces.push_back({first + static_cast<int64_t>(f), j, polygon, window, {}, 0.0, true});
    }
}

} // namespace

extern "C" int64_t cf_polygons(const double *x, const int64_t *nonmortar, const int64_t *mortar,
                               int64_t n_pairs, const int64_t *pairs, double *integrals,
                               int32_t *met) {
  std::vector<Facet> others;
  std::vector<Piece> pieces;
  std::vector<std::size_t> order;
  std::vector<double> sums;
  std::fill(met, met + n_pairs, 0);
  int64_t found = 0;
  for (int64_t first = 0, last = 0; first < n_pairs; first = last) {
    const int64_t *facet = nonmortar + 4 * pairs[2 * first];
    const Vector origin = position(x, facet[0]);
    const Facet own(x, facet, origin);
    for (others.clear(); last < n_pairs && pairs[2 * last] == pairs[2 * first]; ++last)
      others.emplace_back(x, mortar + 4 * pairs[2 * last + 1], origin);
    sums.assign(n_pair5 * others.size(), 0.0);
    for (int i = 0; i < own.triangles; ++i) {
      const Plane plane(own, i);
      if (!(plane.area > 0.0))
        continue;
      gather(others, first, plane, pieces);
      look(pieces, order);
      const Shape shape(plane.p);
      for (const Piece &piece : pieces) {
        if (!piece.visible)
          continue;
        met[piece.pair] |= 1 << (4 * i + piece.other);
        const Values values(piece.polygon, shape, Shape(piece.window.p));
        const PlaneIntegrals q = integrate(piece.polygon, values);
        const std::array<int, n_plane> place = places(own, i, piece.window);
        double *sum = sums.data() + n_pair5 * (piece.pair - first);
        for (int k = 0; k < n_plane; ++k)
          sum[place[k]] += q[k];
      }
    }
    for (int64_t s = first; s < last; ++s) {
      to_nodes(own, others[s - first], sums.data() + n_pair5 * (s - first), 1,
               integrals + n_pair * s);
      found += met[s] != 0;
    }
  }
  return found;
}
