// Derivatives of D, of the weighted jumps and of the forces on the mortar nodes, facet by facet.
#include "kernels.h"
#include "polygon_derivatives.hpp"
#include <vector>

namespace {

using namespace polygon;

constexpr double negligible = 1e-14; // derivative of a facet's masses that is round-off, of the largest

struct Surfaces {
  const double *x;
  const int64_t *nonmortar, *mortar, *pairs;
  const int32_t *met;
  const double *integrals, *multiplier;
};

// The multiplier's basis on a facet, Phi = A N: A = diag(d) B^-1 with the masses' B = (1 - delta) m +
// delta diag(d), or A = 1, which does not change with the masses.
struct Basis {
  const double *A, *inverse; // (4, 4)
  double delta;
  bool standard;
};

// One nonmortar facet with the mortar facets it meets. Its nodes are its own, then those of the
// mortar facets, each once; rows of derivatives have three columns per node.
class Block {
public:
  Block(const Surfaces &surfaces, const Basis &on_facet, int64_t first, int64_t last)
      : in(surfaces), basis(on_facet), facet(in.nonmortar + 4 * in.pairs[2 * first]),
        origin(position(in.x, facet[0])), own(in.x, facet, origin) {
    for (int64_t s = first; s < last; ++s) {
      const int64_t *f = in.mortar + 4 * in.pairs[2 * s + 1];
      others.insert(others.end(), f, f + node_count(f));
    }
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    width = 3 * (own.nodes + others.size());
    mass_rows.resize(n_mass * width);
    force_rows.resize(3 * others.size() * width);
    reach_rows.resize(12 * width);
    mixed.resize(4 * others.size());
    for (int64_t s = first; s < last; ++s)
      add(s);
    list_moving();
    finish_forces();
  }

  void write(int64_t n, int64_t *row_of, int32_t *starts, int32_t *columns, double *values,
             int64_t &rows, int64_t &count) const {
    std::vector<double> row;
    const auto put = [&](int64_t number, const double *from) {
      row_of[rows] = number;
      for (std::size_t i = 0; i < width; ++i)
        if (from[i] != 0.0) {
          columns[count] = static_cast<int32_t>(3 * node(i / 3) + i % 3);
          values[count++] = from[i];
        }
      starts[++rows] = static_cast<int32_t>(count);
    };
    for (int j = 0; j < own.nodes; ++j) {
      row.assign(width, 0.0);
      for (int k = 0; k < own.nodes; ++k)
        add_mass(1.0, j, k, row);
      put(facet[j], row.data());
      for (int c = 0; c < 3; ++c) {
        jump(j, c, row);
        put(n + 3 * facet[j] + c, row.data());
      }
    }
    for (std::size_t l = 0; l < others.size(); ++l)
      for (int c = 0; c < 3; ++c)
        put(4 * n + 3 * others[l] + c, force_rows.data() + (3 * l + c) * width);
    for (int k = 0; basis.standard && k < own.nodes; ++k) // sum_j (D_jj delta_jk - m_jk) lambda_j
      for (int c = 0; c < 3; ++c) {
        row.assign(width, 0.0);
        for (int j = 0; j < own.nodes; ++j)
          add_mass(multiplier(k, c) - multiplier(j, c), j, k, row);
        put(4 * n + 3 * facet[k] + c, row.data());
      }
  }

private:
  int64_t node(std::size_t k) const {
    const std::size_t n = own.nodes;
    return k < n ? facet[k] : others[k - n];
  }
  double multiplier(int j, int c) const { return in.multiplier[3 * facet[j] + c]; }
  double mass_of(int j, int k) const { return mass[pair4[j][k]]; }

  // One segment's integrals, and the rows of what is linear in them at a constant basis.
  void add(int64_t s) {
    const int64_t *f = in.mortar + 4 * in.pairs[2 * s + 1];
    const double *q = in.integrals + n_pair * s;
    const Facet other(in.x, f, origin);
    double sums[n_pair5 * n_columns5] = {}, d[n_pair * n_columns];
    add_derivatives(own, other, in.met[s], sums);
    derivatives_to_nodes(own, other, sums, d);
    std::size_t place[4];
    for (int l = 0; l < other.nodes; ++l)
      place[l] = std::lower_bound(others.begin(), others.end(), f[l]) - others.begin();
    const auto spread = [&](double factor, int integral, double *row) {
      const double *from = d + n_columns * integral;
      for (int i = 0; i < 3 * own.nodes; ++i)
        row[i] += factor * from[i];
      for (int l = 0; l < other.nodes; ++l)
        for (int c = 0; c < 3; ++c)
          row[3 * (own.nodes + place[l]) + c] += factor * from[12 + 3 * l + c];
    };
    for (int i = 0; i < n_mass; ++i) {
      spread(1.0, i, mass_rows.data() + i * width);
      mass[i] += q[i];
    }
    for (int k = 0; k < own.nodes; ++k) {
      double pushes[3] = {}; // by the multiplier, per int N_k N_l
      for (int j = 0; j < own.nodes; ++j)
        for (int c = 0; c < 3; ++c)
          pushes[c] += multiplier(j, c) * basis.A[4 * j + k];
      for (int l = 0; l < other.nodes; ++l) {
        const int integral = n_mass + 4 * k + l;
        mixed[4 * place[l] + k] += q[integral];
        for (int c = 0; c < 3; ++c) {
          reach[3 * k + c] += q[integral] * other.vertex[l].x[c];
          spread(pushes[c], integral, force_rows.data() + (3 * place[l] + c) * width);
          spread(other.vertex[l].x[c], integral, reach_rows.data() + (3 * k + c) * width);
        }
      }
    }
  }

  // Which columns move the masses: within what is covered the edges of mortar facets cancel.
  void list_moving() {
    double largest = 0.0;
    for (const double value : mass_rows)
      largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < width; ++i) {
      double size = 0.0;
      for (int k = 0; k < n_mass; ++k)
        size = std::max(size, std::abs(mass_rows[k * width + i]));
      if (size > negligible * largest)
        moving.push_back(i);
    }
  }

  void add_masses(const double *factors, double *row) const {
    for (const std::size_t i : moving)
      for (int k = 0; k < n_mass; ++k)
        row[i] += factors[k] * mass_rows[k * width + i];
  }
  void add_mass(double factor, int j, int k, std::vector<double> &row) const {
    double factors[n_mass] = {};
    factors[pair4[j][k]] = factor;
    add_masses(factors, row.data());
  }

  // Factors of the masses in f sum_k dA_jk y_k = f (dd_j z_j - sum_ab A_ja dB_ab z_b), z = B^-1 y;
  // delta is constant.
  void through_basis(double f, int j, const double *y, double *factors) const {
    for (int a = 0; a < own.nodes; ++a) {
      double za = 0.0;
      for (int b = 0; b < own.nodes; ++b)
        za += basis.inverse[4 * a + b] * y[b];
      for (int b = 0; b < own.nodes; ++b) { // z_a stands for z_b in the row of b
        factors[pair4[a][b]] -= f * basis.A[4 * j + b] * (1.0 - basis.delta) * za;
        factors[pair4[a][b]] += f * ((a == j ? za : 0.0) - basis.A[4 * j + a] * basis.delta * za);
      }
    }
  }

  void finish_forces() {
    if (basis.standard)
      return;
    for (std::size_t l = 0; l < others.size(); ++l)
      for (int c = 0; c < 3; ++c) {
        double factors[n_mass] = {};
        for (int j = 0; j < own.nodes; ++j)
          through_basis(multiplier(j, c), j, mixed.data() + 4 * l, factors);
        add_masses(factors, force_rows.data() + (3 * l + c) * width);
      }
  }

  // d sum_l M_jl (x_l - x_j), of component c.
  void jump(int j, int c, std::vector<double> &row) const {
    double y[4] = {}, factors[n_mass] = {};
    row.assign(width, 0.0);
    const double at = own.vertex[j].x[c];
    for (int k = 0; k < own.nodes; ++k) {
      const double a = basis.A[4 * j + k];
      for (std::size_t i = 0; i < width; ++i)
        row[i] += a * reach_rows[(3 * k + c) * width + i];
      y[k] = reach[3 * k + c];
      for (int b = 0; b < own.nodes; ++b) {
        y[k] -= at * mass_of(k, b);
        factors[pair4[k][b]] -= a * at;
      }
    }
    if (!basis.standard)
      through_basis(1.0, j, y, factors);
    for (int k = 0; basis.standard && k < own.nodes; ++k) // sum_k (D_jj delta_jk - m_jk) (x_k - x_j)
      factors[pair4[j][k]] += at - own.vertex[k].x[c];
    add_masses(factors, row.data());
    move(j, c, row);
  }

  // sum_l M_jl (dx_l - dx_j)
  void move(int j, int c, std::vector<double> &row) const {
    for (std::size_t l = 0; l < others.size(); ++l) {
      double M = 0.0;
      for (int k = 0; k < own.nodes; ++k)
        M += basis.A[4 * j + k] * mixed[4 * l + k];
      row[3 * (own.nodes + l) + c] += M;
      row[3 * j + c] -= M;
    }
    for (int k = 0; basis.standard && k < own.nodes; ++k) {
      row[3 * k + c] -= mass_of(j, k);
      row[3 * j + c] += mass_of(j, k);
    }
  }

  const Surfaces &in;
  const Basis basis;
  const int64_t *facet;
  const Vector origin;
  const Facet own;
  std::vector<int64_t> others; // mortar nodes, ascending
  std::size_t width = 0;
  double mass[n_mass] = {}, reach[12] = {}; // reach: sum_l x_l int N_k N_l
  std::vector<double> mixed;                // int N_k N_l at 4 l + k
  std::vector<double> mass_rows, force_rows, reach_rows;
  std::vector<std::size_t> moving;
};

} // namespace

extern "C" int64_t cf_polygon_rows(const double *x, int64_t n_nonmortar, const int64_t *nonmortar,
                                   const int64_t *mortar, int32_t standard, int64_t n_segments,
                                   const int64_t *pairs, const int32_t *met,
                                   const double *integrals, const double *multiplier,
                                   const double *A, const double *inverse, const double *delta,
                                   int64_t *row_of, int32_t *starts, int32_t *columns,
                                   double *values) {
  const Surfaces in{x, nonmortar, mortar, pairs, met, integrals, multiplier};
  int64_t rows = 0, count = 0, number = 0;
  starts[0] = 0;
  for (int64_t first = 0, last = 0; first < n_segments; first = last, ++number) {
    while (last < n_segments && pairs[2 * last] == pairs[2 * first])
      ++last;
    const Basis basis{A + 16 * number, inverse + 16 * number, delta[number], standard != 0};
    Block(in, basis, first, last).write(n_nonmortar, row_of, starts, columns, values, rows, count);
  }
  return rows;
}
