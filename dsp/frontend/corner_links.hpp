// SPDX-License-Identifier: Apache-2.0
// Which corners may be next to each other: each corner has four half edges, and the nearest corner along one of them
// whose own half edge points back, and whose bright squares lie on the other side, is its neighbour there. With the
// image, the edge between them must be seen: bright on one side and dark on the other all the way.
// Buffers are sized at construction. One thread per object.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/core/image_view.hpp"
#include "dsp/frontend/corner_fit.hpp"

namespace srd::dsp {

// Half edges 0..3 follow each other clockwise in the image: roughly right, down, left, up.
struct CornerNode {
  float u = 0, v = 0;                           // px
  std::array<std::array<float, 2>, 4> along{};  // unit vectors of the half edges
  std::array<int, 4> link{-1, -1, -1, -1};      // the neighbour at each half edge; -1: none
  std::array<std::int8_t, 4> back{};            // which of the neighbour's half edges leads back
  bool bright = false;                          // between half edges 0 and 1
  float contrast = 0;                           // grey levels from dark to bright
  bool usable = true;                           // false: a stronger corner lies at the same place
  std::uint8_t cells = 0;                       // bit i: four neighbours close a square between half edges i and i + 1
  std::uint8_t depth = 0;                       // 0: detected; else how many corners in a row were only sighted, up to this one
};

// The node of a fit, without links.
[[nodiscard]] CornerNode node_of(const CornerFit& corner);

class CornerLinks {
 public:
  explicit CornerLinks(std::size_t max_corners);

  // Strongest corner first. No more corners than announced. image: which the corners are of, or empty; kept.
  void build(std::span<const CornerFit> corners, const GrayView& image);
  // The corners in their order, then what was added.
  [[nodiscard]] std::span<const CornerNode> nodes() const { return nodes_; }
  // A node without links, beside the corners. False: no room, there may be as many as corners were announced.
  [[nodiscard]] bool add(const CornerNode& node);
  // To the nearest usable corner among the few dozen that were looked at, px; 0: none.
  [[nodiscard]] float gap(std::size_t node) const { return gap_[node]; }
  [[nodiscard]] bool sees_edges() const { return image_.width > 0; }
  [[nodiscard]] const GrayView& image() const { return image_; }
  // An edge of the image runs from a corner along its half edge to another corner. Always true without an image.
  [[nodiscard]] bool edge_seen(const CornerNode& from, int half, const CornerNode& to) const;
  // Calls visit(index) for every usable node no further than reach from (u, v), and for some that are.
  template <class Visit>
  void near(float u, float v, float reach, Visit&& visit) const {
    const int c0 = column_of(u - reach), c1 = column_of(u + reach), r0 = row_of(v - reach), r1 = row_of(v + reach);
    for (int r = r0; r <= r1; ++r)
      for (int c = c0; c <= c1; ++c) visit_bucket(r, c, visit);
  }

 private:
  struct Candidate {
    int node = -1;
    std::int8_t back = 0;
    float cost = 0;
  };
  void sort_into_buckets();
  void find_twins();
  void find_candidates(std::size_t from);
  void consider(std::size_t from, std::size_t to);
  void keep_mutual();
  void find_cells();
  [[nodiscard]] bool closes(std::size_t from, int half) const;
  [[nodiscard]] int column_of(float u) const;
  [[nodiscard]] int row_of(float v) const;
  template <class Visit>
  void visit_bucket(int row, int column, Visit&& visit) const {
    const std::size_t bucket = static_cast<std::size_t>(row * bucket_columns_ + column);
    for (int i = first_[bucket]; i >= 0; i = next_[static_cast<std::size_t>(i)]) visit(static_cast<std::size_t>(i));
  }

  std::size_t max_nodes_;
  GrayView image_{};
  std::vector<CornerNode> nodes_;
  std::vector<std::array<Candidate, 4>> candidates_;
  std::vector<float> gap_;
  std::vector<int> first_, next_;  // lists of nodes, a bucket each
  float origin_u_ = 0, origin_v_ = 0, bucket_size_ = 1;
  int bucket_columns_ = 1, bucket_rows_ = 1;
};

}  // namespace srd::dsp
