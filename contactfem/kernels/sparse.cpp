// Sparse matrices by rows: from triplets, and products.
#include "kernels.h"
#include <algorithm>
#include <vector>

extern "C" int64_t cf_by_rows(int64_t n_rows, int64_t count, const int64_t *rows,
                              const int64_t *columns, const double *values, int32_t *starts,
                              int32_t *sorted_columns, double *sorted_values) {
  std::fill(starts, starts + n_rows + 1, 0);
  for (int64_t e = 0; e < count; ++e)
    ++starts[rows[e] + 1];
  for (int64_t i = 0; i < n_rows; ++i)
    starts[i + 1] += starts[i];
  std::vector<int32_t> next(starts, starts + n_rows);
  for (int64_t e = 0; e < count; ++e) {
    const int32_t at = next[rows[e]]++;
    sorted_columns[at] = static_cast<int32_t>(columns[e]);
    sorted_values[at] = values[e];
  }
  return count;
}

extern "C" int64_t cf_product(int64_t n_rows, int64_t n_columns, const int32_t *a_starts,
                              const int32_t *a_columns, const double *a_values,
                              const int32_t *b_starts, const int32_t *b_columns,
                              const double *b_values, int32_t *starts, int32_t *columns,
                              double *values) {
  std::vector<double> sum(n_columns, 0.0);
  std::vector<char> met(n_columns, 0);
  int32_t count = starts[0] = 0;
  for (int64_t i = 0; i < n_rows; ++i) {
    for (int32_t k = a_starts[i]; k < a_starts[i + 1]; ++k) {
      const int32_t j = a_columns[k];
      for (int32_t l = b_starts[j]; l < b_starts[j + 1]; ++l) {
        const int32_t column = b_columns[l];
        sum[column] += a_values[k] * b_values[l];
        if (!met[column]) {
          met[column] = 1;
          columns[count++] = column;
        }
      }
    }
    for (int32_t k = starts[i]; k < count; ++k) {
      values[k] = sum[columns[k]];
      sum[columns[k]] = 0.0;
      met[columns[k]] = 0;
    }
    starts[i + 1] = count;
  }
  return count;
}
