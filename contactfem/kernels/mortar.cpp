// Entries of the mortar operators from integrals over segments, and their derivatives.
#include "kernels.h"
#include <algorithm>
#include <array>
#include <utility>
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

constexpr int64_t d_column = -1, gap_column = -2;
using Integrals = std::array<double, n_integrals>;

// What an entry is made of: sums of integrals over its segment.
constexpr Integrals whole[2] = {{1, 1}, {0, 1, 1}};               // int N_i
constexpr Integrals toward_d[2] = {{0, 0, 0, 1}, {0, 0, 0, 0, 1}}; // int N_i zeta
constexpr Integrals toward_c[2] = {{1, 1, 0, -1}, {0, 1, 1, 0, -1}};
constexpr Integrals gaps[2] = {{0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1}};
constexpr Integrals shared = {0, 1}; // int N_1 N_2

Integrals combined(double a, const Integrals &p, double b, const Integrals &q) {
  Integrals r;
  for (int i = 0; i < n_integrals; ++i)
    r[i] = a * p[i] + b * q[i];
  return r;
}

double dot(const Integrals &factors, const double *q) {
  double sum = 0.0;
  for (int i = 0; i < n_integrals; ++i)
    sum += factors[i] * q[i];
  return sum;
}

struct Output {
  int64_t *rows, *columns;
  double *values;
  int64_t *segment; // NULL where derivatives are not wanted
  double *by_integrals, *by_masses;
  int64_t count;

  void add(int64_t row, int64_t column, int64_t s, const double *q, const Integrals &factors) {
    rows[count] = row;
    columns[count] = column;
    values[count] = dot(factors, q);
    if (segment != nullptr) {
      segment[count] = s;
      std::copy(factors.begin(), factors.end(), by_integrals + n_integrals * count);
      std::fill(by_masses + n_masses * count, by_masses + n_masses * (count + 1), 0.0);
    }
    ++count;
  }

  // The last entry's change by the basis, which changes with the masses by dA (2, 3).
  void add_basis(double by_first, double by_second, const double *dA) {
    if (segment == nullptr || dA == nullptr)
      return;
    for (int m = 0; m < n_masses; ++m)
      by_masses[n_masses * (count - 1) + m] = by_first * dA[m] + by_second * dA[n_masses + m];
  }
};

} // namespace

extern "C" int64_t cf_entries(const int64_t *nonmortar, const int64_t *mortar,
                              const uint8_t *carries, int32_t standard, int64_t n_segments,
                              const int64_t *pairs, const double *integrals, const int64_t *facet,
                              const uint8_t *covered, const double *A, const double *dA,
                              int64_t *rows, int64_t *columns, double *values, int64_t *segment,
                              double *by_integrals, double *by_masses) {
  Output out{rows, columns, values, segment, by_integrals, by_masses, 0};
  for (int64_t s = 0; s < n_segments; ++s) {
    const int64_t *ends = nonmortar + 2 * pairs[2 * s], *others = mortar + 2 * pairs[2 * s + 1];
    const bool both = carries[ends[0]] && carries[ends[1]];
    const double *q = integrals + n_integrals * s;
    for (int k = 0; k < 2; ++k) {
      if (!covered[facet[s]] || !carries[ends[k]])
        continue;
      const double *a = A + 4 * facet[s] + 2 * k;
      const double *da = dA == nullptr ? nullptr : dA + 12 * facet[s] + 6 * k;
      const int64_t row = ends[k];
      out.add(row, d_column, s, q, whole[k]);
      // The gap is weighted with the mean of Phi and N; beside a node without multiplier with N.
      const double of_basis = carries[ends[1 - k]] ? 0.5 : 0.0;
      const double own = 1.0 - of_basis + of_basis * a[k], far = of_basis * a[1 - k];
      out.add(row, gap_column, s, q, combined(own, gaps[k], far, gaps[1 - k]));
      if (of_basis > 0.0)
        out.add_basis(of_basis * dot(gaps[0], q), of_basis * dot(gaps[1], q), da);
      const std::pair<int64_t, const Integrals *> through_basis[] = {
          {others[0], toward_c}, {others[1], toward_d}};
      for (const auto &[column, parts] : through_basis) {
        out.add(row, column, s, q, combined(a[0], parts[0], a[1], parts[1]));
        out.add_basis(dot(parts[0], q), dot(parts[1], q), da);
      }
      // D_jj delta_jk - int Phi_j N_k of nonmortar nodes, where it is not zero
      if (!both)
        out.add(row, ends[1 - k], s, q, combined(-1.0, whole[1 - k], 0.0, shared));
      if (both && standard) {
        out.add(row, ends[1 - k], s, q, combined(-1.0, shared, 0.0, shared));
        out.add(row, ends[k], s, q, shared);
      }
    }
  }
  return out.count;
}

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
