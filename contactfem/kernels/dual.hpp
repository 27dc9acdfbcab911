// Forward-mode differentiation: a number that carries its derivatives along N directions.
#ifndef CONTACTFEM_DUAL_HPP
#define CONTACTFEM_DUAL_HPP
#include <array>
#include <cmath>

template <int N> struct Dual {
  double v = 0.0;
  std::array<double, N> d{};

  Dual() = default;
  Dual(double value) : v(value) {} // constants convert silently: their derivatives are zero

  static Dual variable(double value, int direction) {
    Dual r(value);
    r.d[direction] = 1.0;
    return r;
  }
};

// f(x) with derivative f'(x) = slope
template <int N> Dual<N> chain(const Dual<N> &x, double value, double slope) {
  Dual<N> r(value);
  for (int i = 0; i < N; ++i)
    r.d[i] = slope * x.d[i];
  return r;
}

// f(x, y) with partial derivatives fx and fy
template <int N>
Dual<N> chain(const Dual<N> &x, const Dual<N> &y, double value, double fx, double fy) {
  Dual<N> r(value);
  for (int i = 0; i < N; ++i)
    r.d[i] = fx * x.d[i] + fy * y.d[i];
  return r;
}

template <int N> Dual<N> operator+(const Dual<N> &x, const Dual<N> &y) {
  return chain(x, y, x.v + y.v, 1.0, 1.0);
}
template <int N> Dual<N> operator-(const Dual<N> &x, const Dual<N> &y) {
  return chain(x, y, x.v - y.v, 1.0, -1.0);
}
template <int N> Dual<N> operator*(const Dual<N> &x, const Dual<N> &y) {
  return chain(x, y, x.v * y.v, y.v, x.v);
}
template <int N> Dual<N> operator/(const Dual<N> &x, const Dual<N> &y) {
  return chain(x, y, x.v / y.v, 1.0 / y.v, -x.v / (y.v * y.v));
}
template <int N> Dual<N> operator*(double s, const Dual<N> &x) { return chain(x, s * x.v, s); }
template <int N> Dual<N> operator-(double s, const Dual<N> &x) { return chain(x, s - x.v, -1.0); }
template <int N> Dual<N> operator+(double s, const Dual<N> &x) { return chain(x, s + x.v, 1.0); }
template <int N> Dual<N> sqrt(const Dual<N> &x) {
  const double r = std::sqrt(x.v);
  return chain(x, r, 0.5 / r);
}

inline double value(double x) { return x; }
template <int N> double value(const Dual<N> &x) { return x.v; }

#endif
