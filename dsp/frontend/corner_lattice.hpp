// SPDX-License-Identifier: Apache-2.0
// Corners on square lattices. Cells of linked corners grow into pieces; a piece takes in a corner where the map from its
// rows and columns to the image says that one is due, lets go of one that the map of its neighbours contradicts, and
// joins another piece when their maps agree across the gap. Buffers are sized at construction. One thread per object.
#pragma once

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

  void build(const CornerLinks& links);
  [[nodiscard]] int pieces() const { return pieces_; }
  [[nodiscard]] int size(int piece) const { return size_[static_cast<std::size_t>(piece)]; }  // corners
  [[nodiscard]] std::span<const Place> places() const { return places_; }
  // How far a corner lies from where its neighbours expect it, against what is usual round it and for
  // a corner so faint; more than 1 is too far.
  [[nodiscard]] float misfit(std::size_t node) const { return misfit_[node]; }

 private:
  // A misfit of 1: so many times what is usual nearby, plus what a corner's own error and a print's may be.
  static constexpr float kUsual = 6.0f, kOfStep = 0.02f, kOfPixel = 0.25f;
  static constexpr int modulo4(int i) { return i & 3; }

  struct Slot {
    std::uint64_t key;
    int node;
  };
  struct Shift {
    int turn, row, column, votes;
    float weight;
  };
  void flood(std::size_t from);
  [[nodiscard]] bool continues(std::size_t from, int direction, std::size_t to) const;
  bool attach(const CornerLinks& links);
  [[nodiscard]] int due(const CornerLinks& links, int piece, int row, int column, Place& place) const;
  bool prune();
  void measure_misfits();
  [[nodiscard]] float misfit_of(std::size_t node, float step);
  [[nodiscard]] float usual_at(int piece, int row, int column) const;
  void drop_small();
  bool join(const CornerLinks& links);
  [[nodiscard]] bool agree(const CornerLinks& links, int host, int guest, Shift& shift) const;
  void move(int host, int guest, const Shift& shift);
  [[nodiscard]] bool local_map(int piece, int row, int column, int without, LocalMap& map) const;
  [[nodiscard]] bool bright_at(int piece, int row, int column) const;
  [[nodiscard]] static bool turn_towards(const CornerNode& node, const LocalMap& map, int& turn);

  void settle(std::size_t node, const Place& place);
  void release(std::size_t node);
  void rebuild_table();
  void insert(const Place& place, int node);
  [[nodiscard]] int find(int piece, int row, int column) const;

  std::span<const CornerNode> nodes_;
  std::vector<Place> places_;
  std::vector<Slot> table_;
  std::vector<int> queue_;
  std::vector<float> misfit_, distance_;
  std::vector<std::uint8_t> refused_;  // contradicted once: does not come back
  std::size_t mask_ = 0;
  int pieces_ = 0;
  std::array<bool, kMaxPieces> bright_{};  // at row 0, column 0
  std::array<int, kMaxPieces> size_{};
};

}  // namespace srd::dsp
