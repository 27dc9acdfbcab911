/* Plain C interface of the contact kernels; every array is C-ordered, lengths in m.
 *
 * Nodes of both surfaces are numbered together: x[2*i], x[2*i+1] is the current position of node i.
 * A facet is a pair of node numbers (a, b); the outward normal of its body is (dy, -dx) of b - a.
 * Normals are nodal unit normals, outward from the nonmortar side, one for every node (only those of
 * nonmortar nodes are read). All functions return a count or 0, and a negative number on bad input.
 */
#ifndef CONTACTFEM_KERNELS_H
#define CONTACTFEM_KERNELS_H
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

/* Candidate pairs: facets that face each other, the mortar one in a box that meets what the nonmortar
 * one sweeps along its normals, by `ahead` to the front and behind[e] to the back. Writes at most `capacity` pairs (nonmortar facet, mortar facet), ordered by
 * nonmortar facet, then mortar facet; returns how many there are (call again if more than capacity). */
int64_t cf_pairs(const double *x, const double *normals, int64_t n_nonmortar, const int64_t *nonmortar,
                 int64_t n_mortar, const int64_t *mortar, double ahead, const double *behind,
                 int64_t capacity, int64_t *pairs);

/* The segment of every pair: range[2*s], range[2*s+1] is its interval of the facet coordinate xi in
 * [-1, 1] (empty: both 0). integrals[7*s + i], over the segment with N the nonmortar shape functions:
 *   0: N1 N1   1: N1 N2   2: N2 N2   3: N1 zeta   4: N2 zeta   5: N1 g   6: N2 g
 * with zeta in [0, 1] the mortar facet coordinate of the projection and g the gap [m].
 * If axisymmetric is not 0 all of them are taken around the axis x = 0: times 2 pi x of nonmortar.
 * distance[s] is the mean |g|. derivatives, if not NULL, is (pairs, 7, 12): with respect to the
 * positions of a and b, the normals at a and b, and the positions of the mortar nodes c and d. */
int64_t cf_segments(const double *x, const double *normals, const int64_t *nonmortar,
                    const int64_t *mortar, int32_t axisymmetric, int64_t n_pairs,
                    const int64_t *pairs, double *range,
                    double *integrals, double *distance, double *derivatives);

/* Entries of the mortar operators: D_jj = int Phi_j, M_jl = int Phi_j N_l and g_j = int w_j g, with
 * Phi = A N on each facet and w = (Phi + N) / 2; also, with the sign of a mortar entry, those of nonmortar nodes (see Mortar
 * in mortar.py). facet[s] numbers the covered facets with their basis: A is (facets, 2, 2), dA by the
 * first three integrals of the facet (facets, 2, 2, 3), or NULL for a constant basis. Nodes that do
 * not carry a multiplier, and facets that are not covered, have no entries. Writes at most 12 of each
 * segment: row, column (-1 for D, -2 for g), value; and, unless NULL, the segment and the derivatives
 * for cf_entry_rows. Returns how many. */
int64_t cf_entries(const int64_t *nonmortar, const int64_t *mortar, const uint8_t *carries,
                   int32_t standard, int64_t n_segments, const int64_t *pairs,
                   const double *integrals, const int64_t *facet, const uint8_t *covered,
                   const double *A, const double *dA, int64_t *rows, int64_t *columns,
                   double *values, int64_t *segment, double *by_integrals, double *by_masses);

/* Derivatives by positions of some quantities of segments, as rows of a sparse matrix. Segments stand
 * ordered by nonmortar facet (pairs[2*s]), with `derivatives` from cf_segments. Quantity e belongs to
 * segment[e], ascending, and changes by
 *   sum_i by_integrals[7*e + i] dq_i(own segment) + sum_i by_masses[3*e + i] sum_s dq_i(s)
 * with the first three integrals summed over the m segments of its facet. around and by_around say on
 * which three nodes the normal of a nonmortar node depends, (n, 3), and how, (n, 2, 3, 2). Row e has
 * 12 + 4*m entries: the nodes around a, around b, then c and d of each segment of the facet; columns
 * repeat, and add up. Returns how many entries there are. */
int64_t cf_entry_rows(const int64_t *nonmortar, const int64_t *mortar, const int64_t *around,
                      const double *by_around, int64_t n_segments, const int64_t *pairs,
                      const double *derivatives, int64_t n_entries, const int64_t *segment,
                      const double *by_integrals, const double *by_masses, double *values,
                      int32_t *columns);

/* Facets in space are quadruples of node numbers, counter-clockwise seen from outside; a triangle
 * has its last node twice. x[3*i] to x[3*i+2] is the position of node i.
 *
 * Candidate pairs: facets that face each other and whose boxes, the nonmortar one swollen by radius,
 * meet. Otherwise as cf_pairs. */
int64_t cf_polygon_pairs(const double *x, int64_t n_nonmortar, const int64_t *nonmortar,
                         int64_t n_mortar, const int64_t *mortar, double radius, int64_t capacity,
                         int64_t *pairs);

/* What the facets of pairs share, seen along the normals of the nonmortar triangles (a quadrilateral
 * is four, see polygon.hpp). Pairs stand ordered by nonmortar facet, and all candidates of a facet
 * among them: where several mortar triangles cover one place, the nearest counts.
 * integrals[26*s + i], over this common part, with N the functions of each facet's nodes:
 *   i < 10: int N_j N_k of nonmortar nodes j <= k, rows of the upper triangle one after the other
 *   10 + 4*j + l: int N_j N_l of nonmortar node j and mortar node l
 * Bit 4*i + j of met[s]: whether triangles i and j of the facets share something. Returns how many
 * pairs do. */
int64_t cf_polygons(const double *x, const int64_t *nonmortar, const int64_t *mortar,
                    int64_t n_pairs, const int64_t *pairs, double *integrals, int32_t *met);

/* Derivatives by positions at fixed multipliers, as rows of a sparse matrix with three columns per
 * node, facet by facet. Rows of the same number add up:
 *   j: D_jj                                    of nonmortar node j < n_nonmortar
 *   n_nonmortar + 3*j + c: sum_l M_jl (x_l - x_j)
 *   4*n_nonmortar + 3*l + c: sum_j M_jl lambda_j  of node l
 * Segments are pairs with what cf_polygons gave for them, ordered by nonmortar facet. Each facet has
 * a basis Phi = A N, A = diag(d) inverse with inverse = ((1 - delta) m + delta diag(d))^-1; or, if
 * standard is not 0, A = 1, and M also holds D_jj delta_jk - m_jk of nonmortar nodes. row_of holds
 * the number of each row; a facet with a nodes and b different mortar nodes has 4 a + 3 b rows, with
 * standard 3 a more, and at most 3 (a + b) entries in each. Returns the count of rows. */
int64_t cf_polygon_rows(const double *x, int64_t n_nonmortar, const int64_t *nonmortar,
                        const int64_t *mortar, int32_t standard, int64_t n_segments,
                        const int64_t *pairs, const int32_t *met, const double *integrals,
                        const double *multiplier, const double *A, const double *inverse,
                        const double *delta, int64_t *row_of, int32_t *starts, int32_t *columns,
                        double *values);

/* Triplets (row, column, value) ordered by rows: those of row i stand from starts[i] to starts[i+1],
 * in the order they come in. Returns their count. */
int64_t cf_by_rows(int64_t n_rows, int64_t count, const int64_t *rows, const int64_t *columns,
                   const double *values, int32_t *starts, int32_t *sorted_columns,
                   double *sorted_values);

/* Product of two matrices by rows, the second with n_columns. Entries at the same place add up; the
 * columns of a row are not sorted. Returns the count of entries, at most those of all rows of the
 * second that the entries of the first ask for. */
int64_t cf_product(int64_t n_rows, int64_t n_columns, const int32_t *a_starts,
                   const int32_t *a_columns, const double *a_values, const int32_t *b_starts,
                   const int32_t *b_columns, const double *b_values, int32_t *starts,
                   int32_t *columns, double *values);

#ifdef __cplusplus
}
#endif
#endif
