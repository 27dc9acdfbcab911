// Candidate facet pairs of two surfaces, with a bounding-volume tree over the mortar facets.
#include "kernels.h"
#include "tree.hpp"

namespace {

Box<2> box_of(const double *x, const int64_t *facet) {
  Box<2> box;
  for (int k = 0; k < 2; ++k)
    box.include(x + 2 * facet[k]);
  return box;
}

// The quadrilateral that the facet sweeps when it moves by +-radius along its nodal normals.
Box<2> swept(const double *x, const double *normals, const int64_t *facet, double radius) {
  Box<2> box;
  for (int k = 0; k < 2; ++k) {
    const int64_t i = facet[k];
    for (const double r : {-radius, radius}) {
      const double end[2] = {x[2 * i] + r * normals[2 * i], x[2 * i + 1] + r * normals[2 * i + 1]};
      box.include(end);
    }
  }
  return box;
}

bool facing(const double *x, const int64_t *e, const int64_t *f) {
  const double ex = x[2 * e[1]] - x[2 * e[0]], ey = x[2 * e[1] + 1] - x[2 * e[0] + 1];
  const double fx = x[2 * f[1]] - x[2 * f[0]], fy = x[2 * f[1] + 1] - x[2 * f[0] + 1];
  return ex * fx + ey * fy < 0.0; // of the edges, hence of their normals
}

} // namespace

extern "C" int64_t cf_pairs(const double *x, const double *normals, int64_t n_nonmortar,
                            const int64_t *nonmortar, int64_t n_mortar, const int64_t *mortar,
                            double radius, int64_t capacity, int64_t *pairs) {
  if (n_nonmortar < 0 || n_mortar < 0 || !(radius > 0.0))
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
    tree.visit(swept(x, normals, facet, radius), [&](std::size_t f) {
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
