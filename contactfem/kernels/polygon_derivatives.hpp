// Derivatives of the integrals over the polygons of a facet pair by the positions of its nodes.
//
// When corner k of a triangle moves by delta, its function L_p changes by -L_k grad L_p . delta and
// its edges move along; so by Reynolds' transport theorem, with f the integrand,
//   d int L_p K_w = -int L_k K_w grad L_p . delta + sum over edges of int f L_k delta . normal
// and likewise for corners of the mortar triangle. The first term is made of the integrals themselves.
#ifndef CONTACTFEM_POLYGON_DERIVATIVES_HPP
#define CONTACTFEM_POLYGON_DERIVATIVES_HPP
#include "polygon.hpp"

namespace polygon {

constexpr int n_corners = 6; // of a triangle pair: nonmortar ones, then those of the window
using PlaneDerivatives = std::array<std::array<double, 2 * n_corners>, n_plane>;

inline void add_inside(const PlaneIntegrals &q, const Shape &own, const Shape &other,
                       PlaneDerivatives &d) {
  for (int p = 0; p < 3; ++p)
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 2; ++c) {
        const double slope = own.slope[p][c];
        for (int r = 0; r < 3; ++r) {
          d[pair3[p][r]][2 * k + c] -= (r == p ? 2.0 : 1.0) * slope * q[pair3[k][r]];
          d[6 + 3 * p + r][2 * k + c] -= slope * q[6 + 3 * k + r];
          d[6 + 3 * p + r][6 + 2 * k + c] -= other.slope[r][c] * q[6 + 3 * p + k];
        }
      }
}

// Edges: two points of Gauss's rule are exact for the three linear factors.
inline void add_edges(const Polygon &polygon, const Values &at, PlaneDerivatives &d) {
  constexpr double gauss[2] = {0.21132486540518711775, 0.78867513459481288225};
  for (int i = 0; i < polygon.n; ++i) {
    const int j = (i + 1) % polygon.n;
    const Point &a = polygon.p[i], &b = polygon.p[j];
    const double half[2] = {0.5 * (b.v - a.v), 0.5 * (a.u - b.u)}; // normal times half the length
    const bool own = polygon.line[i] < 3;
    const int first = own ? polygon.line[i] : polygon.line[i] - 3, second = (first + 1) % 3;
    for (const double s : gauss) {
      double L[3], K[3];
      for (int p = 0; p < 3; ++p) {
        L[p] = (1.0 - s) * at.L[i][p] + s * at.L[j][p];
        K[p] = (1.0 - s) * at.K[i][p] + s * at.K[j][p];
      }
      const double *moved = own ? L : K;
      for (const int k : {first, second}) {
        const int column = (own ? 0 : 6) + 2 * k;
        const double w[2] = {half[0] * moved[k], half[1] * moved[k]};
        for (int p = 0; p < 3; ++p)
          for (int c = 0; c < 2; ++c) {
            const double wp = w[c] * L[p];
            for (int r = p; r < 3; ++r)
              d[pair3[p][r]][column + c] += wp * L[r];
            for (int r = 0; r < 3; ++r)
              d[6 + 3 * p + r][column + c] += wp * K[r];
          }
      }
    }
  }
}

// Derivatives in space of integrals over vertices (40 of them): by five vertices of each facet.
constexpr int n_columns5 = 6 * n_vertices;
constexpr int n_columns = 24; // by four nodes of each facet

// One plane integral: corners move in the plane, and the plane turns with the nonmortar triangle,
// which shows by the heights h of the mortar corners: du_i = e1 . (dx_i - dx_0) - h_i e1 . dn.
inline void add_in_space(const double *d, const Facet &own, int s, const Plane &plane,
                         const Window &window, double *out) {
  double tilt[2] = {0.0, 0.0};
  const auto add = [&](int vertex, double u, double v, double n) {
    for (int c = 0; c < 3; ++c)
      out[3 * vertex + c] += u * plane.e1.x[c] + v * plane.e2.x[c] + n * plane.n.x[c];
  };
  for (int w = 0; w < 3; ++w) {
    add(n_vertices + window.corner[w], d[6 + 2 * w], d[7 + 2 * w], 0.0);
    tilt[0] -= window.height[w] * d[6 + 2 * w];
    tilt[1] -= window.height[w] * d[7 + 2 * w];
  }
  const Point &a = plane.p[1], &b = plane.p[2];
  const double y[2] = {tilt[0] / plane.area, tilt[1] / plane.area};
  const double by_a = b.u * y[1] - b.v * y[0], by_b = -y[1] * a.u; // y . (da x b + a x db)
  add(own.corner(s, 0), d[0], d[1], -by_a - by_b);
  add(own.corner(s, 1), d[2], d[3], by_a);
  add(own.corner(s, 2), d[4], d[5], by_b);
}

// Adds those of the triangle pairs that a facet pair is made of, (40, 30).
inline void add_derivatives(const Facet &own, const Facet &other, int32_t met, double *sums) {
  Polygon polygon;
  for (int i = 0; i < own.triangles; ++i) {
    if ((met >> (4 * i) & 15) == 0)
      continue;
    const Plane plane(own, i);
    const Shape shape(plane.p);
    for (int j = 0; j < other.triangles; ++j) {
      if ((met >> (4 * i + j) & 1) == 0)
        continue;
      const Window window(other, j, plane);
      if (!intersect(plane, window, polygon))
        continue;
      const Shape window_shape(window.p);
      const Values at(polygon, shape, window_shape);
      PlaneDerivatives d{};
      add_inside(integrate(polygon, at), shape, window_shape, d);
      add_edges(polygon, at, d);
      const std::array<int, n_plane> place = places(own, i, window);
      for (int k = 0; k < n_plane; ++k)
        add_in_space(d[k].data(), own, i, plane, window, sums + n_columns5 * place[k]);
    }
  }
}

// From vertices to nodes, of rows and of columns: (40, 30) to (26, 24).
inline void derivatives_to_nodes(const Facet &own, const Facet &other, double *sums, double *to) {
  double narrow[n_pair5 * n_columns];
  for (int i = 0; i < n_pair5; ++i)
    for (int side = 0; side < 2; ++side) {
      const double *from = sums + n_columns5 * i + 3 * n_vertices * side;
      const double share = (side == 0 ? own : other).nodes == 4 ? 0.25 : 0.0;
      for (int k = 0; k < 12; ++k)
        narrow[n_columns * i + 12 * side + k] = from[k] + share * from[3 * n_mean + k % 3];
    }
  to_nodes(own, other, narrow, n_columns, to);
}

} // namespace polygon

#endif
