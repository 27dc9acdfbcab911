// Candidate facet pairs of two surfaces, with a bounding-volume tree over the mortar facets.
#include "kernels.h"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace {

struct Box {
  double lo[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  double hi[2] = {-std::numeric_limits<double>::infinity(),
                  -std::numeric_limits<double>::infinity()};

  void include(double px, double py) {
    lo[0] = std::min(lo[0], px);
    lo[1] = std::min(lo[1], py);
    hi[0] = std::max(hi[0], px);
    hi[1] = std::max(hi[1], py);
  }
  void include(const Box &b) {
    include(b.lo[0], b.lo[1]);
    include(b.hi[0], b.hi[1]);
  }
  bool meets(const Box &b) const {
    return lo[0] <= b.hi[0] && b.lo[0] <= hi[0] && lo[1] <= b.hi[1] && b.lo[1] <= hi[1];
  }
};

Box box_of(const double *x, const int64_t *facet) {
  Box box;
  for (int k = 0; k < 2; ++k)
    box.include(x[2 * facet[k]], x[2 * facet[k] + 1]);
  return box;
}

// What a facet sweeps when it moves along its nodal normals: four points, and the directions along
// which a box may lie beside them.
class Swept {
public:
  Swept(const double *x, const double *normals, const int64_t *facet, double ahead, double behind) {
    for (int k = 0; k < 2; ++k) {
      const int64_t i = facet[k];
      const double n[2] = {normals[2 * i], normals[2 * i + 1]};
      for (int side = 0; side < 2; ++side) {
        const double r = side == 0 ? -behind : ahead;
        for (int c = 0; c < 2; ++c)
          points_[2 * k + side][c] = x[2 * i + c] + r * n[c];
        box_.include(points_[2 * k + side][0], points_[2 * k + side][1]);
      }
      across_[k][0] = -n[1];
      across_[k][1] = n[0];
    }
    for (int k = 0; k < 2; ++k)
      for (const auto &p : points_)
        range_[k].include(p[0] * across_[k][0] + p[1] * across_[k][1], 0.0);
  }

  bool meets(const Box &b) const {
    if (!box_.meets(b))
      return false;
    for (int k = 0; k < 2; ++k) {
      const double *d = across_[k];
      const double middle = 0.5 * (d[0] * (b.lo[0] + b.hi[0]) + d[1] * (b.lo[1] + b.hi[1]));
      const double half =
          0.5 * (std::abs(d[0]) * (b.hi[0] - b.lo[0]) + std::abs(d[1]) * (b.hi[1] - b.lo[1]));
      const double room = rounding * (std::abs(middle) + half);
      if (middle + half + room < range_[k].lo[0] || range_[k].hi[0] < middle - half - room)
        return false;
    }
    return true;
  }

private:
  static constexpr double rounding = 1e-12; // facets that end where others start belong to both

  double points_[4][2], across_[2][2];
  Box box_, range_[2];
};

// A complete binary tree by median splits: node k covers order[first, last), its children 2k+1, 2k+2.
class Tree {
public:
  explicit Tree(std::vector<Box> facets) : facets_(std::move(facets)), order_(facets_.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::size_t leaves = 1;
    while (leaves * leaf_size < facets_.size())
      leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    if (!facets_.empty())
      build(0, 0, facets_.size());
  }

  template <typename Visit> void visit(const Swept &swept, const Visit &visit_facet) const {
    if (!facets_.empty())
      descend(0, 0, facets_.size(), swept, visit_facet);
  }

private:
  static constexpr std::size_t leaf_size = 4;

  bool is_leaf(std::size_t node) const { return 2 * node + 2 >= nodes_.size(); }

  void build(std::size_t node, std::size_t first, std::size_t last) {
    Box box;
    for (std::size_t i = first; i < last; ++i)
      box.include(facets_[order_[i]]);
    nodes_[node] = box;
    if (is_leaf(node))
      return;
    const int axis = box.hi[1] - box.lo[1] > box.hi[0] - box.lo[0];
    const std::size_t middle = first + (last - first) / 2;
    const auto centre = [&](std::size_t f) { return facets_[f].lo[axis] + facets_[f].hi[axis]; };
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(first),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(last),
                     [&](std::size_t f, std::size_t g) {
                       return centre(f) < centre(g) || (centre(f) == centre(g) && f < g);
                     });
    build(2 * node + 1, first, middle);
    build(2 * node + 2, middle, last);
  }

  template <typename Visit>
  void descend(std::size_t node, std::size_t first, std::size_t last, const Swept &swept,
               const Visit &visit_facet) const {
    if (first == last || !swept.meets(nodes_[node]))
      return;
    if (is_leaf(node)) {
      for (std::size_t i = first; i < last; ++i)
        if (swept.meets(facets_[order_[i]]))
          visit_facet(order_[i]);
      return;
    }
    const std::size_t middle = first + (last - first) / 2;
    descend(2 * node + 1, first, middle, swept, visit_facet);
    descend(2 * node + 2, middle, last, swept, visit_facet);
  }

  std::vector<Box> facets_;
  std::vector<std::size_t> order_;
  std::vector<Box> nodes_;
};

bool facing(const double *x, const int64_t *e, const int64_t *f) {
  const double ex = x[2 * e[1]] - x[2 * e[0]], ey = x[2 * e[1] + 1] - x[2 * e[0] + 1];
  const double fx = x[2 * f[1]] - x[2 * f[0]], fy = x[2 * f[1] + 1] - x[2 * f[0] + 1];
  return ex * fx + ey * fy < 0.0; // of the edges, hence of their normals
}

} // namespace

extern "C" int64_t cf_pairs(const double *x, const double *normals, int64_t n_nonmortar,
                            const int64_t *nonmortar, int64_t n_mortar, const int64_t *mortar,
                            double ahead, const double *behind, int64_t capacity,
                            int64_t *pairs) {
  if (n_nonmortar < 0 || n_mortar < 0 || !(ahead > 0.0))
    return -1;
  std::vector<Box> boxes(static_cast<std::size_t>(n_mortar));
  for (int64_t f = 0; f < n_mortar; ++f)
    boxes[static_cast<std::size_t>(f)] = box_of(x, mortar + 2 * f);
  const Tree tree(std::move(boxes));

  int64_t count = 0;
  std::vector<int64_t> hits;
  for (int64_t e = 0; e < n_nonmortar; ++e) {
    const int64_t *facet = nonmortar + 2 * e;
    hits.clear();
    tree.visit(Swept(x, normals, facet, ahead, behind[e]), [&](std::size_t f) {
      if (facing(x, facet, mortar + 2 * f))
        hits.push_back(static_cast<int64_t>(f));
    });
    std::sort(hits.begin(), hits.end());
    for (const int64_t f : hits) {
      if (count < capacity) {
        pairs[2 * count] = e;
        pairs[2 * count + 1] = f;
      }
      ++count;
    }
  }
  return count;
}
