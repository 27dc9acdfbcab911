// Segments of a two-dimensional interface and the integrals over them (paper 1.4, Figure 2).
#include "dual.hpp"
#include "kernels.h"
#include <algorithm>
#include <cstddef>
#include <limits>

namespace {

constexpr int n_inputs = 12;
constexpr int n_integrals = 7;
// Three points: exact where the normal is constant (two would do), else the error is of the fourth
// order in its turn along the facet.
constexpr int n_points = 3;
constexpr double gauss_x[n_points] = {-0.77459666924148337704, 0.0, 0.77459666924148337704};
constexpr double gauss_w[n_points] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
// Sine of the angle between a mortar facet and the normals below which it covers nothing: seen along
// its own direction its coordinate would be 0 / 0.
constexpr double upright = 1e-12;
constexpr double turn = 6.28318530717958647693; // 2 pi

template <typename T> struct Point {
  T x, y;
};
template <typename T> Point<T> operator-(const Point<T> &p, const Point<T> &q) {
  return {p.x - q.x, p.y - q.y};
}
template <typename T> T dot(const Point<T> &p, const Point<T> &q) { return p.x * q.x + p.y * q.y; }
template <typename T> T cross(const Point<T> &p, const Point<T> &q) {
  return p.x * q.y - p.y * q.x;
}
// Linear interpolation on a facet, xi in [-1, 1].
template <typename T> Point<T> at(const Point<T> &a, const Point<T> &b, const T &xi) {
  const T n1 = 0.5 * (1.0 - xi), n2 = 0.5 * (1.0 + xi);
  return {n1 * a.x + n2 * b.x, n1 * a.y + n2 * b.y};
}

template <typename T> struct Pair {
  Point<T> a, b, na, nb, c, d;
};

// One Newton step for the facet coordinate whose normal passes through c: (x(xi) - c) x n(xi) = 0.
template <typename T> T project_step(const Pair<T> &s, const Point<T> &c, const T &xi) {
  const Point<T> r = at(s.a, s.b, xi) - c, n = at(s.na, s.nb, xi);
  const Point<T> half_edge{0.5 * (s.b.x - s.a.x), 0.5 * (s.b.y - s.a.y)};
  const Point<T> half_turn{0.5 * (s.nb.x - s.na.x), 0.5 * (s.nb.y - s.na.y)};
  return xi - cross(r, n) / (cross(half_edge, n) + cross(r, half_turn));
}

// On which side of the normal at xi the point c lies, > 0 towards the end b.
double side(const Pair<double> &s, const Point<double> &c, double xi) {
  return cross(at(s.a, s.b, xi) - c, at(s.na, s.nb, xi));
}

// Projection of c onto the facet along the interpolated normal, clipped to [-1, 1]; not a number
// where the normals meet before they reach c. The signs at both ends decide, as far beyond them
// there may be no normal through c, or two. Equal points give equal projections to the last bit.
double project(const Pair<double> &s, const Point<double> &c) {
  double lo = -1.0, hi = 1.0;
  const double first = side(s, c, lo), last = side(s, c, hi);
  if (first >= 0.0 && last >= 0.0)
    return hi;
  if (first <= 0.0 && last <= 0.0)
    return lo;
  if (!(first > 0.0 && last < 0.0))
    return std::numeric_limits<double>::quiet_NaN();
  double xi = (first + last) / (first - last); // secant; Newton's steps stay between signs
  for (int k = 0; k < 60; ++k) {
    (side(s, c, xi) > 0.0 ? lo : hi) = xi;
    double next = project_step(s, c, xi);
    if (!(next >= lo && next <= hi))
      next = 0.5 * (lo + hi);
    const double change = std::abs(next - xi);
    xi = next;
    if (change <= std::numeric_limits<double>::epsilon())
      break;
  }
  return xi;
}

// The last Newton step, repeated with live derivatives, is the implicit function theorem.
double live(const Pair<double> &, const Point<double> &, double xi) { return xi; }
template <int N> Dual<N> live(const Pair<Dual<N>> &s, const Point<Dual<N>> &c, double xi) {
  Dual<N> r = project_step(s, c, Dual<N>(xi));
  r.v = xi; // keep the value of both instantiations the same to the last bit
  return r;
}

// Whether the mortar facet runs against the nonmortar one, seen along the normal at xi.
bool opposed(const Pair<double> &s, double xi) {
  const Point<double> edge = s.d - s.c, n = at(s.na, s.nb, xi);
  return cross(edge, n) > upright * std::sqrt(dot(edge, edge) * dot(n, n));
}

// Interval of the facet that the mortar facet covers: clipping at +-1 is the projection of the
// nonmortar end nodes along their own normals.
template <typename T>
bool covered(const Pair<T> &s, const Pair<double> &plain_pair, T *lo, T *hi) {
  const double xc = project(plain_pair, plain_pair.c), xd = project(plain_pair, plain_pair.d);
  const Point<double> edge = plain_pair.b - plain_pair.a;
  if (!(xd < xc && dot(edge, edge) > 0.0))
    return false;
  *lo = xd > -1.0 ? live(s, s.d, xd) : T(-1.0);
  *hi = xc < 1.0 ? live(s, s.c, xc) : T(1.0);
  return opposed(plain_pair, value(*lo)) && opposed(plain_pair, value(*hi));
}

template <typename T>
void integrate(const Pair<T> &s, bool axisymmetric, const T &lo, const T &hi, T *q,
               double *distance) {
  using std::sqrt;
  const Point<T> edge = s.b - s.a, mortar_edge = s.d - s.c;
  const T scale = 0.5 * (hi - lo) * (0.5 * sqrt(dot(edge, edge)));
  double weight = 0.0, mean = 0.0;
  for (int g = 0; g < n_points; ++g) {
    const T xi = 0.5 * (1.0 - gauss_x[g]) * lo + 0.5 * (1.0 + gauss_x[g]) * hi;
    T w = gauss_w[g] * scale;
    const Point<T> x = at(s.a, s.b, xi), n = at(s.na, s.nb, xi);
    const T zeta = cross(x - s.c, n) / cross(mortar_edge, n);
    const Point<T> xm{s.c.x + zeta * mortar_edge.x, s.c.y + zeta * mortar_edge.y};
    const T gap = dot(xm - x, n) / sqrt(dot(n, n)); // (2)
    weight += value(w);
    mean += value(w) * std::abs(value(gap));
    if (axisymmetric)
      w = turn * x.x * w;
    const T w1 = w * (0.5 * (1.0 - xi)), w2 = w * (0.5 * (1.0 + xi));
    const T n1 = 0.5 * (1.0 - xi), n2 = 0.5 * (1.0 + xi);
    const T add[n_integrals] = {w1 * n1,   w1 * n2,   w2 * n2, w1 * zeta,
                                w2 * zeta, w1 * gap, w2 * gap};
    for (int i = 0; i < n_integrals; ++i)
      q[i] = q[i] + add[i];
  }
  *distance = weight > 0.0 ? mean / weight : 0.0;
}

struct Input {
  const double *x, *normals;
  const int64_t *nonmortar, *mortar;
};

Pair<double> gather(const Input &in, int64_t facet, int64_t other) {
  const int64_t *e = in.nonmortar + 2 * facet, *f = in.mortar + 2 * other;
  const auto p = [](const double *v, int64_t i) { return Point<double>{v[2 * i], v[2 * i + 1]}; };
  return {p(in.x, e[0]),       p(in.x, e[1]), p(in.normals, e[0]),
          p(in.normals, e[1]), p(in.x, f[0]), p(in.x, f[1])};
}

Pair<Dual<n_inputs>> differentiated(const Pair<double> &s) {
  const auto p = [](const Point<double> &q, int k) {
    return Point<Dual<n_inputs>>{Dual<n_inputs>::variable(q.x, k),
                                 Dual<n_inputs>::variable(q.y, k + 1)};
  };
  return {p(s.a, 0), p(s.b, 2), p(s.na, 4), p(s.nb, 6), p(s.c, 8), p(s.d, 10)};
}

template <typename T>
bool segment(const Pair<T> &s, const Pair<double> &values, bool axisymmetric, double *range, T *q,
             double *distance) {
  T lo, hi;
  if (!covered(s, values, &lo, &hi))
    return false;
  range[0] = value(lo);
  range[1] = value(hi);
  integrate(s, axisymmetric, lo, hi, q, distance);
  return true;
}

} // namespace

extern "C" int64_t cf_segments(const double *x, const double *normals, const int64_t *nonmortar,
                               const int64_t *mortar, int32_t axisymmetric, int64_t n_pairs,
                               const int64_t *pairs, double *range, double *integrals,
                               double *distance, double *derivatives) {
  const Input in{x, normals, nonmortar, mortar};
  const bool around = axisymmetric != 0;
  int64_t found = 0;
  for (int64_t s = 0; s < n_pairs; ++s) {
    const Pair<double> pair = gather(in, pairs[2 * s], pairs[2 * s + 1]);
    double *q = integrals + n_integrals * s;
    std::fill(q, q + n_integrals, 0.0);
    range[2 * s] = range[2 * s + 1] = distance[s] = 0.0;
    if (derivatives == nullptr) {
      found += segment(pair, pair, around, range + 2 * s, q, distance + s);
      continue;
    }
    Dual<n_inputs> live_q[n_integrals];
    found += segment(differentiated(pair), pair, around, range + 2 * s, live_q, distance + s);
    for (int i = 0; i < n_integrals; ++i) {
      q[i] = live_q[i].v;
      std::copy(live_q[i].d.begin(), live_q[i].d.end(),
                derivatives + n_inputs * (n_integrals * s + i));
    }
  }
  return found;
}
