// Candidate facet pairs of two surfaces, with a bounding-volume tree over the mortar facets.
#include "kernels.h"
#include "tree.hpp"
#include <cmath>

namespace {

Box<2> box_of(const double *x, const int64_t *facet) {
  Box<2> box;
  for (int k = 0; k < 2; ++k)
    box.include(x + 2 * facet[k]);
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
        box_.include(points_[2 * k + side]);
      }
      across_[k][0] = -n[1];
      across_[k][1] = n[0];
    }
    for (int k = 0; k < 2; ++k) {
      low_[k] = std::numeric_limits<double>::infinity();
      high_[k] = -low_[k];
      for (const auto &p : points_) {
        const double place = p[0] * across_[k][0] + p[1] * across_[k][1];
        low_[k] = std::min(low_[k], place);
        high_[k] = std::max(high_[k], place);
      }
    }
  }

  bool meets(const Box<2> &b) const {
    if (!box_.meets(b))
      return false;
    for (int k = 0; k < 2; ++k) {
      const double *d = across_[k];
      const double middle = 0.5 * (d[0] * (b.lo[0] + b.hi[0]) + d[1] * (b.lo[1] + b.hi[1]));
      const double half =
          0.5 * (std::abs(d[0]) * (b.hi[0] - b.lo[0]) + std::abs(d[1]) * (b.hi[1] - b.lo[1]));
      const double room = rounding * (std::abs(middle) + half);
      if (middle + half + room < low_[k] || high_[k] < middle - half - room)
        return false;
    }
    return true;
  }

private:
  static constexpr double rounding = 1e-12; // facets that end where others start belong to both

  double points_[4][2], across_[2][2];
  Box<2> box_;
  double low_[2], high_[2];
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
  std::vector<Box<2>> boxes(static_cast<std::size_t>(n_mortar));
  for (int64_t f = 0; f < n_mortar; ++f)
    boxes[static_cast<std::size_t>(f)] = box_of(x, mortar + 2 * f);
  const Tree<2> tree(std::move(boxes));

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
