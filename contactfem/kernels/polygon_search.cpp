// Candidate facet pairs of two surfaces in space.
#include "kernels.h"
#include "polygon.hpp"
#include "tree.hpp"

namespace {

using polygon::position;
using polygon::Vector;

Box<3> box_of(const double *x, const int64_t *facet, double margin) {
  Box<3> box;
  for (int k = 0; k < 4; ++k)
    box.include(x + 3 * facet[k], margin);
  return box;
}

// Twice the area vector: of the diagonals, which is right for a triangle (a, b, c, c) as well.
Vector area_vector(const double *x, const int64_t *f) {
  return polygon::cross(position(x, f[2]) - position(x, f[0]),
                        position(x, f[3]) - position(x, f[1]));
}

} // namespace

extern "C" int64_t cf_polygon_pairs(const double *x, int64_t n_nonmortar, const int64_t *nonmortar,
                                    int64_t n_mortar, const int64_t *mortar, double radius,
                                    int64_t capacity, int64_t *pairs) {
  if (n_nonmortar < 0 || n_mortar < 0 || !(radius > 0.0))
    return -1;
  std::vector<Box<3>> boxes(static_cast<std::size_t>(n_mortar));
  std::vector<Vector> areas(static_cast<std::size_t>(n_mortar));
  for (int64_t f = 0; f < n_mortar; ++f) {
    boxes[static_cast<std::size_t>(f)] = box_of(x, mortar + 4 * f, 0.0);
    areas[static_cast<std::size_t>(f)] = area_vector(x, mortar + 4 * f);
  }
  const Tree<3> tree(std::move(boxes));

  int64_t count = 0;
  std::vector<int64_t> hits;
  for (int64_t e = 0; e < n_nonmortar; ++e) {
    const Vector area = area_vector(x, nonmortar + 4 * e);
    hits.clear();
    tree.visit(box_of(x, nonmortar + 4 * e, radius), [&](std::size_t f) {
      if (polygon::dot(area, areas[f]) < 0.0)
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
