// Derivatives of mortar entries: from those of the segments' integrals to those of the positions.
#include "kernels.h"
#include <algorithm>
#include <vector>

namespace {

constexpr int n_integrals = 7;
constexpr int n_masses = 3; // the integrals that the basis of a facet depends on
constexpr int n_inputs = 12; // what segments are differentiated by, see cf_segments
constexpr int n_around = 12; // two components of the three nodes that the normals at a and b depend on
constexpr int n_mortar = 4;
constexpr int n_own = n_around + n_mortar;

struct Nodes {
  const int64_t *nonmortar, *mortar, *around;
  const double *by_around; // normals by these nodes' positions
};

void put(int64_t node, int32_t *columns) {
  columns[0] = static_cast<int32_t>(2 * node);
  columns[1] = columns[0] + 1;
}

// One integral by the positions around a and b, and of c and d: the normals are put in.
void with_normals(const double *by_input, const Nodes &in, const int64_t *pair, double *out) {
  for (int k = 0; k < 2; ++k) {
    const double *normal = in.by_around + 12 * in.nonmortar[2 * pair[0] + k];
    const double *by_normal = by_input + 4 + 2 * k;
    double *at = out + 6 * k;
    for (int i = 0; i < 6; ++i)
      at[i] = by_normal[0] * normal[i] + by_normal[1] * normal[6 + i];
    at[2] += by_input[2 * k]; // the node itself stands in the middle
    at[3] += by_input[2 * k + 1];
  }
  std::copy(by_input + 8, by_input + n_inputs, out + n_around);
}

void add(double factor, const double *row, int count, double *to) {
  for (int i = 0; i < count; ++i)
    to[i] += factor * row[i];
}

} // namespace

extern "C" int64_t cf_entry_rows(const int64_t *nonmortar, const int64_t *mortar,
                                 const int64_t *around, const double *by_around, int64_t n_segments,
                                 const int64_t *pairs, const double *derivatives, int64_t n_entries,
                                 const int64_t *segment, const double *by_integrals,
                                 const double *by_masses, double *values, int32_t *columns) {
  const Nodes in{nonmortar, mortar, around, by_around};
  std::vector<double> rows; // of all integrals of the segments of one facet
  int64_t written = 0, entry = 0;
  for (int64_t first = 0, last = 0; first < n_segments; first = last) {
    while (last < n_segments && pairs[2 * last] == pairs[2 * first])
      ++last;
    const int64_t count = last - first;
    rows.resize(count * n_integrals * n_own);
    for (int64_t i = 0; i < count * n_integrals; ++i)
      with_normals(derivatives + n_inputs * (n_integrals * first + i), in,
                   pairs + 2 * (first + i / n_integrals), rows.data() + n_own * i);
    for (; entry < n_entries && segment[entry] < last; ++entry) {
      double *value = values + written;
      int32_t *column = columns + written;
      const int64_t width = n_around + n_mortar * count;
      std::fill(value, value + width, 0.0);
      for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 3; ++i)
          put(around[3 * nonmortar[2 * pairs[2 * first] + k] + i], column + 6 * k + 2 * i);
      for (int64_t s = 0; s < count; ++s) {
        const double *row = rows.data() + n_own * n_integrals * s;
        const int64_t *ends = mortar + 2 * pairs[2 * (first + s) + 1];
        const int64_t at = n_around + n_mortar * s;
        put(ends[0], column + at);
        put(ends[1], column + at + 2);
        const bool own = first + s == segment[entry];
        for (int i = 0; i < n_integrals; ++i) {
          double factor = own ? by_integrals[n_integrals * entry + i] : 0.0;
          factor += i < n_masses ? by_masses[n_masses * entry + i] : 0.0;
          if (factor != 0.0) {
            add(factor, row + n_own * i, n_around, value);
            add(factor, row + n_own * i + n_around, n_mortar, value + at);
          }
        }
      }
      written += width;
    }
  }
  return written;
}
