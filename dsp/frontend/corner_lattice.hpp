// SPDX-License-Identifier: Apache-2.0
// Corners on square lattices. Cells of linked corners grow into pieces; a piece takes in a corner where the map from its
// rows and columns to the image says that one is due, lets go of one that the map of its neighbours contradicts, and
// joins another piece when their maps agree across the gap. Where the grey levels cross but no corner was detected, the
// lattice goes on over what it sights there. Buffers are sized at construction. One thread per object.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/frontend/corner_links.hpp"

namespace srd::dsp {

// (row, column) after quarter turns, each from the columns' direction to the rows'.
inline void turn_cell(int turns, int& row, int& column) {
  for (int k = turns & 3; k > 0; --k) {
    const int r = row;
    row = column;
    column = -r;
  }
}

class CornerLattice {
 public:
  static constexpr int kMaxPieces = 64;

  // Where a corner stands. turn: its half edge i + turn runs along the lattice's direction i (columns up, rows up,
  // columns down, rows down).
  struct Place {
    int piece = -1, row = 0, column = 0, turn = 0;
  };
  // The lattice's map round a cell: its place in the image and the steps to the next row and the next column, px.
  struct LocalMap {
    float u, v, row_u, row_v, column_u, column_v;
    float step;   // mean length of the two steps
    int members;  // that it comes from
  };

  explicit CornerLattice(std::size_t max_corners);

  // What is sighted is added to the links' nodes.
  void build(CornerLinks& links);
  [[nodiscard]] int pieces() const { return pieces_; }
  [[nodiscard]] int size(int piece) const { return size_[static_cast<std::size_t>(piece)]; }  // corners
  // Of the detected corners.
  [[nodiscard]] std::span<const Place> places() const { return std::span<const Place>(places_).first(corners_); }
  // How many detected corners are next to a node of a piece; the nearest's distance, px, and the least contrast, if any.
  [[nodiscard]] int beside(std::size_t node, float& step, float& contrast) const;
  // How far a corner lies from where its neighbours expect it, against what is usual round it and for
  // a corner so faint; more than 1 is too far.
  [[nodiscard]] float misfit(std::size_t node) const { return misfit_[node]; }

 private:
  // A misfit of 1: so many times what is usual nearby, plus what a corner's own error and a print's may be.
  static constexpr float kUsual = 6.0f, kOfStep = 0.02f, kOfPixel = 0.25f;
  static constexpr int kReturns = 3;  // how often a corner that was contradicted may come back
  static constexpr int modulo4(int i) { return i & 3; }
  static constexpr std::array<int, 4> kRowSteps{0, 1, 0, -1}, kColumnSteps{1, 0, -1, 0};  // of the four directions

  struct Slot {
    std::uint64_t key;
    int node;
  };
  struct Shift {
    int turn, row, column, votes;
    float weight;
  };
  struct Meeting {
    int host, guest;
    Shift shift;
  };
  static constexpr std::size_t kMaxMeetings = 1024;
  void flood(std::size_t from);
  [[nodiscard]] bool continues(std::size_t from, int direction, std::size_t to) const;
  bool attach(const CornerLinks& links);
  bool sight(CornerLinks& links);
  bool sight_at(CornerLinks& links, std::size_t from, int direction);
  void meet(int host, int guest, const Shift& shift);
  bool join_where_they_meet();
  [[nodiscard]] bool overlap_fits(int host, int guest, const Shift& shift) const;
  [[nodiscard]] int due(const CornerLinks& links, int piece, int row, int column, Place& place) const;
  bool prune();
  void measure_misfits();
  [[nodiscard]] float misfit_of(std::size_t node, float step);
  [[nodiscard]] float usual_at(int piece, int row, int column) const;
  void drop_small();
  void drop_loose();
  bool join(const CornerLinks& links);
  [[nodiscard]] bool agree(const CornerLinks& links, int host, int guest, Shift& shift) const;
  void move(int host, int guest, const Shift& shift);
  [[nodiscard]] bool local_map(int piece, int row, int column, int without, LocalMap& map, bool detected_only = false) const;
  [[nodiscard]] bool bright_at(int piece, int row, int column) const;
  [[nodiscard]] static bool turn_towards(const CornerNode& node, const LocalMap& map, int& turn);

  void settle(std::size_t node, const Place& place);
  void release(std::size_t node);
  void rebuild_table();
  void insert(const Place& place, int node);
  [[nodiscard]] int find(int piece, int row, int column) const;

  std::span<const CornerNode> nodes_;
  std::size_t corners_ = 0;  // of the nodes: the detected ones come first
  std::vector<Place> places_;
  std::vector<Slot> table_;
  std::vector<int> queue_;
  std::vector<float> misfit_, distance_;
  std::vector<std::uint8_t> refused_;  // how often it was contradicted
  std::vector<Meeting> meetings_;      // where one piece sighted the corners of another; votes in the shift
  std::size_t mask_ = 0;
  int pieces_ = 0;
  std::array<bool, kMaxPieces> bright_{};  // at row 0, column 0
  std::array<int, kMaxPieces> size_{};     // detected corners
};

}  // namespace srd::dsp
