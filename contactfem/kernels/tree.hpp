// Axis-aligned boxes and a bounding-volume tree over them, in two or three dimensions.
#ifndef CONTACTFEM_TREE_HPP
#define CONTACTFEM_TREE_HPP
#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

template <int dim> struct Box {
  double lo[dim], hi[dim];

  Box() {
    std::fill(lo, lo + dim, std::numeric_limits<double>::infinity());
    std::fill(hi, hi + dim, -std::numeric_limits<double>::infinity());
  }
  void include(const double *p, double margin = 0.0) {
    for (int c = 0; c < dim; ++c) {
      lo[c] = std::min(lo[c], p[c] - margin);
      hi[c] = std::max(hi[c], p[c] + margin);
    }
  }
  void include(const Box &b) {
    include(b.lo);
    include(b.hi);
  }
  bool meets(const Box &b) const {
    for (int c = 0; c < dim; ++c)
      if (lo[c] > b.hi[c] || b.lo[c] > hi[c])
        return false;
    return true;
  }
  int longest() const {
    int axis = 0;
    for (int c = 1; c < dim; ++c)
      if (hi[c] - lo[c] > hi[axis] - lo[axis])
        axis = c;
    return axis;
  }
};

// A complete binary tree by median splits: node k covers order[first, last), its children 2k+1, 2k+2.
template <int dim> class Tree {
public:
  explicit Tree(std::vector<Box<dim>> facets) : facets_(std::move(facets)), order_(facets_.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::size_t leaves = 1;
    while (leaves * leaf_size < facets_.size())
      leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    if (!facets_.empty())
      build(0, 0, facets_.size());
  }

  // Region: anything that says which boxes it meets.
  template <typename Region, typename Visit>
  void visit(const Region &box, const Visit &visit_facet) const {
    if (!facets_.empty())
      descend(0, 0, facets_.size(), box, visit_facet);
  }

private:
  static constexpr std::size_t leaf_size = 4;

  bool is_leaf(std::size_t node) const { return 2 * node + 2 >= nodes_.size(); }

  void build(std::size_t node, std::size_t first, std::size_t last) {
    Box<dim> box;
    for (std::size_t i = first; i < last; ++i)
      box.include(facets_[order_[i]]);
    nodes_[node] = box;
    if (is_leaf(node))
      return;
    const int axis = box.longest();
    const std::size_t middle = first + (last - first) / 2;
    const auto centre = [&](std::size_t f) { return facets_[f].lo[axis] + facets_[f].hi[axis]; };
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(first),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(last),
                     [&](std::size_t f, std::size_t g) {
                       return centre(f) < centre(g) || (centre(f) == centre(g) && f < g);
                     });
    build(2 * node + 1, first, middle);
    build(2 * node + 2, middle, last);
  }

  template <typename Region, typename Visit>
  void descend(std::size_t node, std::size_t first, std::size_t last, const Region &box,
               const Visit &visit_facet) const {
    if (first == last || !box.meets(nodes_[node]))
      return;
    if (is_leaf(node)) {
      for (std::size_t i = first; i < last; ++i)
        if (box.meets(facets_[order_[i]]))
          visit_facet(order_[i]);
      return;
    }
    const std::size_t middle = first + (last - first) / 2;
    descend(2 * node + 1, first, middle, box, visit_facet);
    descend(2 * node + 2, middle, last, box, visit_facet);
  }

  std::vector<Box<dim>> facets_;
  std::vector<std::size_t> order_;
  std::vector<Box<dim>> nodes_;
};

#endif
