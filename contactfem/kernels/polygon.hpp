// Plane geometry of a facet pair: triangles, the plane of a nonmortar one, the polygon two share.
//
// A quadrilateral is four triangles around the mean of its nodes, and its trace is linear on each:
// a vertex function belongs to every node and to the mean, which gives a quarter of it to each node.
// Every nonmortar triangle is integrated in its own plane, seen along its own normal.
#ifndef CONTACTFEM_POLYGON_HPP
#define CONTACTFEM_POLYGON_HPP
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace polygon {

constexpr double on_line = 1e-11; // distance below which a vertex is on an edge, of the first edge
constexpr double upright = 1e-12; // cosine below which a mortar triangle is seen from its edge
constexpr int most_vertices = 24; // each of three cuts may at most double three vertices
constexpr int n_mean = 4;         // number of the mean of a quadrilateral's nodes among its vertices
constexpr int n_vertices = 5;     // of a facet

struct Vector {
  double x[3];
};
inline Vector operator-(const Vector &a, const Vector &b) {
  return {{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};
}
inline double dot(const Vector &a, const Vector &b) {
  return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}
inline Vector cross(const Vector &a, const Vector &b) {
  return {{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
           a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}
inline Vector position(const double *x, int64_t node) {
  return {{x[3 * node], x[3 * node + 1], x[3 * node + 2]}};
}
inline int node_count(const int64_t *facet) { return facet[2] == facet[3] ? 3 : 4; }

// A facet as triangles: corner(s, p) is the vertex at corner p of triangle s.
struct Facet {
  int nodes, triangles;
  Vector vertex[n_vertices];

  Facet(const double *x, const int64_t *facet, const Vector &origin)
      : nodes(node_count(facet)), triangles(nodes == 3 ? 1 : 4), vertex{} {
    for (int k = 0; k < nodes; ++k) {
      vertex[k] = position(x, facet[k]) - origin;
      for (int c = 0; c < 3 && nodes == 4; ++c)
        vertex[n_mean].x[c] += 0.25 * vertex[k].x[c];
    }
  }
  int corner(int s, int p) const { return nodes == 3 ? p : p == 2 ? n_mean : (s + p) % 4; }
};

struct Point {
  double u, v;
};
inline double cross(const Point &a, const Point &b, const Point &c) { // twice the area of (a, b, c)
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

// Linear functions of a counter-clockwise triangle, 1 at one corner and 0 at the others.
struct Shape {
  Point origin;
  double slope[3][2];

  explicit Shape(const Point *p) : origin(p[0]), slope{} {
    const double area = cross(p[0], p[1], p[2]);
    for (int i = 0; i < 3; ++i) {
      const Point &q = p[(i + 1) % 3], &r = p[(i + 2) % 3];
      slope[i][0] = (q.v - r.v) / area;
      slope[i][1] = (r.u - q.u) / area;
    }
  }
  void at(const Point &p, double *value) const {
    for (int i = 0; i < 3; ++i)
      value[i] = slope[i][0] * (p.u - origin.u) + slope[i][1] * (p.v - origin.v);
    value[0] += 1.0;
  }
};

// The plane of a nonmortar triangle: e1 along its first edge, which starts at the origin.
struct Plane {
  Vector first, e1, e2, n;
  double area; // twice that of the triangle
  Point p[3];

  Plane(const Facet &facet, int s) : first(facet.vertex[facet.corner(s, 0)]), e1{}, e2{}, n{}, p{} {
    const Vector a = facet.vertex[facet.corner(s, 1)] - first;
    const Vector b = facet.vertex[facet.corner(s, 2)] - first;
    const Vector c = cross(a, b);
    const double length = std::sqrt(dot(a, a));
    area = std::sqrt(dot(c, c));
    for (int i = 0; i < 3; ++i) {
      e1.x[i] = a.x[i] / length;
      n.x[i] = c.x[i] / area;
    }
    e2 = cross(n, e1);
    p[1] = {length, 0.0};
    p[2] = {dot(b, e1), dot(b, e2)};
  }
};

// A mortar triangle seen in a plane, its corners in reverse order: counter-clockwise there.
struct Window {
  int corner[3]; // vertex of the facet
  Point p[3];
  double height[3];
  bool faces;

  Window(const Facet &facet, int s, const Plane &plane) : corner{}, p{}, height{} {
    for (int w = 0; w < 3; ++w) {
      corner[w] = facet.corner(s, 2 - w);
      const Vector r = facet.vertex[corner[w]] - plane.first;
      p[w] = {dot(r, plane.e1), dot(r, plane.e2)};
      height[w] = dot(r, plane.n);
    }
    const Vector c = cross(facet.vertex[corner[1]] - facet.vertex[corner[0]],
                           facet.vertex[corner[2]] - facet.vertex[corner[0]]);
    faces = cross(p[0], p[1], p[2]) > upright * std::sqrt(dot(c, c));
  }
};

// Edge i runs from vertex i to the next one and lies on line[i]: 0 to 2 are the edges of the
// nonmortar triangle, 3 to 5 those of the mortar one.
struct Polygon {
  int n;
  Point p[most_vertices];
  int line[most_vertices];
};

inline bool apart(const Point *a, const Point *b) {
  const auto beside = [](double a0, double a1, double a2, double b0, double b1, double b2) {
    return std::max({a0, a1, a2}) < std::min({b0, b1, b2}) ||
           std::max({b0, b1, b2}) < std::min({a0, a1, a2});
  };
  return beside(a[0].u, a[1].u, a[2].u, b[0].u, b[1].u, b[2].u) ||
         beside(a[0].v, a[1].v, a[2].v, b[0].v, b[1].v, b[2].v);
}

// Keeps of a polygon what lies left of the line through a and b. A vertex nearer than tol is on the
// line and stays as it is; edges are cut only between an end inside and one outside.
inline bool cut(Polygon &polygon, const Point &a, const Point &b, int line, double tol) {
  const double du = b.u - a.u, dv = b.v - a.v, length = std::sqrt(du * du + dv * dv);
  double side[most_vertices];
  bool outside = false, inside = false;
  for (int i = 0; i < polygon.n; ++i) {
    const double d = (du * (polygon.p[i].v - a.v) - dv * (polygon.p[i].u - a.u)) / length;
    side[i] = std::abs(d) <= tol ? 0.0 : d;
    outside = outside || side[i] < 0.0;
    inside = inside || side[i] > 0.0;
  }
  if (!inside || !outside)
    return inside;
  Polygon kept;
  kept.n = 0;
  const auto keep = [&kept](const Point &p, int on) {
    kept.p[kept.n] = p;
    kept.line[kept.n++] = on;
  };
  for (int i = 0; i < polygon.n; ++i) {
    const int j = (i + 1) % polygon.n;
    const Point &p = polygon.p[i], &q = polygon.p[j];
    if (side[i] >= 0.0)
      keep(p, side[i] == 0.0 && side[j] < 0.0 ? line : polygon.line[i]);
    if (side[i] * side[j] < 0.0) {
      const double t = side[i] / (side[i] - side[j]);
      keep({p.u + t * (q.u - p.u), p.v + t * (q.v - p.v)}, side[i] > 0.0 ? line : polygon.line[i]);
    }
  }
  polygon.n = kept.n;
  std::copy(kept.p, kept.p + kept.n, polygon.p);
  std::copy(kept.line, kept.line + kept.n, polygon.line);
  return polygon.n > 2;
}

// The common part of a nonmortar triangle and a mortar one; whether there is any.
inline bool intersect(const Plane &plane, const Window &window, Polygon &polygon) {
  if (!window.faces || apart(plane.p, window.p))
    return false;
  polygon.n = 3;
  for (int i = 0; i < 3; ++i) {
    polygon.p[i] = plane.p[i];
    polygon.line[i] = i;
  }
  const double tol = on_line * plane.p[1].u;
  for (int e = 0; e < 3; ++e)
    if (!cut(polygon, window.p[e], window.p[(e + 1) % 3], 3 + e, tol))
      return false;
  return true;
}

// Integrals over a polygon: int L_p L_q for p <= q at pair3[p][q], int L_p K_w at 6 + 3 p + w, with
// the functions L of the nonmortar triangle and K of the mortar one.
constexpr int pair3[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
constexpr int n_plane = 15;
using PlaneIntegrals = std::array<double, n_plane>;

struct Values { // of both triangles' functions at the vertices of a polygon
  double L[most_vertices][3], K[most_vertices][3];

  Values(const Polygon &polygon, const Shape &own, const Shape &other) {
    for (int i = 0; i < polygon.n; ++i) {
      own.at(polygon.p[i], L[i]);
      other.at(polygon.p[i], K[i]);
    }
  }
};

// Exact for products of linear functions: int f g = A/12 ((sum f)(sum g) + sum f g) on a triangle.
inline PlaneIntegrals integrate(const Polygon &polygon, const Values &at) {
  PlaneIntegrals q{};
  for (int t = 1; t + 1 < polygon.n; ++t) {
    const int corner[3] = {0, t, t + 1};
    const double weight = cross(polygon.p[0], polygon.p[t], polygon.p[t + 1]) / 24.0;
    double L[4][3] = {}, K[4][3] = {}; // the fourth is the sum of the corners
    for (int c = 0; c < 3; ++c)
      for (int p = 0; p < 3; ++p) {
        L[3][p] += L[c][p] = at.L[corner[c]][p];
        K[3][p] += K[c][p] = at.K[corner[c]][p];
      }
    for (int c = 0; c < 4; ++c)
      for (int p = 0; p < 3; ++p) {
        const double w = weight * L[c][p];
        for (int r = p; r < 3; ++r)
          q[pair3[p][r]] += w * L[c][r];
        for (int r = 0; r < 3; ++r)
          q[6 + 3 * p + r] += w * K[c][r];
      }
  }
  return q;
}

// The integrals of a facet pair over its vertices, or something linear in them.
constexpr int pair5[5][5] = {
    {0, 1, 2, 3, 4}, {1, 5, 6, 7, 8}, {2, 6, 9, 10, 11}, {3, 7, 10, 12, 13}, {4, 8, 11, 13, 14}};
constexpr int n_mass5 = 15;
constexpr int n_pair5 = 40;
// The same over its nodes: int N_j N_k for j <= k at pair4[j][k], int N_j N_l at 10 + 4 j + l.
constexpr int pair4[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
constexpr int n_mass = 10;
constexpr int n_pair = 26;

// Where each plane integral of a triangle pair stands among those over vertices.
inline std::array<int, n_plane> places(const Facet &own, int s, const Window &window) {
  std::array<int, n_plane> place{};
  for (int p = 0; p < 3; ++p)
    for (int r = 0; r < 3; ++r) {
      const int j = own.corner(s, p);
      place[pair3[p][r]] = pair5[j][own.corner(s, r)];
      place[6 + 3 * p + r] = n_mass5 + 5 * j + window.corner[r];
    }
  return place;
}

// What every node gets of integrals over vertices, (40, width), written to (26, width).
inline void to_nodes(const Facet &own, const Facet &other, const double *from, int width,
                     double *to) {
  const double a = own.nodes == 4 ? 0.25 : 0.0, b = other.nodes == 4 ? 0.25 : 0.0;
  const auto row = [&](int i) { return from + width * i; };
  const auto put = [&](int i, const double *p, double f1, const double *p1, double f2,
                       const double *p2, const double *p3) {
    for (int c = 0; c < width; ++c)
      to[width * i + c] = p[c] + f1 * p1[c] + f2 * p2[c] + f1 * f2 * p3[c];
  };
  std::fill(to, to + n_pair * width, 0.0);
  for (int j = 0; j < own.nodes; ++j) {
    for (int k = j; k < own.nodes; ++k)
      put(pair4[j][k], row(pair5[j][k]), a, row(pair5[k][n_mean]), a, row(pair5[j][n_mean]),
          row(pair5[n_mean][n_mean]));
    for (int l = 0; l < other.nodes; ++l) {
      const int at = n_mass5 + 5 * j + l, mean = n_mass5 + 5 * n_mean + l;
      put(n_mass + 4 * j + l, row(at), a, row(mean), b, row(at - l + n_mean),
          row(mean - l + n_mean));
    }
  }
}

} // namespace polygon

#endif
