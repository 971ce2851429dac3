// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_links.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {

namespace {

// Sine of the angle between a half edge and the way to the neighbour. Spread ink turns the edges of a fit by up to a
// quarter of a right angle, the next corner but one in the next row lies 27 degrees off.
constexpr float kCone = 0.42f;
constexpr float kTwin = 1.5f;  // px: two fits this near are of one corner
constexpr int kExamined = 96;  // corners round one after which no neighbour is looked for further out
// Where an edge is looked at: so many places between its corners, so far to either side of it.
constexpr int kLooks = 5;
constexpr float kBeside = 0.20f;  // of its length, and at least a pixel: wider than ink spreads, within thin squares
// Of the corners' contrast: what its sides differ by at each place, and on the average. Blur takes most of it where
// squares are few pixels wide; the squares round a corner that was missed turn it round.
constexpr float kMinDiffers = -0.05f, kMeanDiffers = 0.15f;
constexpr float kSidesDiffer = 2.0f;  // ratio of a cell's opposite sides

}  // namespace

CornerNode node_of(const CornerFit& corner) {
  CornerNode node;
  node.u = corner.corner.u.to<float>();
  node.v = corner.corner.v.to<float>();
  const auto along = [](const Direction& n) {
    return std::array{static_cast<float>(-n.y) / 16384.0f, static_cast<float>(n.x) / 16384.0f};
  };
  const auto opposite = [](const std::array<float, 2>& a) { return std::array{-a[0], -a[1]}; };
  std::array<float, 2> e = along(corner.shape.n1), f = along(corner.shape.n2);
  if (std::abs(e[0]) < std::abs(f[0])) std::swap(e, f);
  if (e[0] < 0) e = opposite(e);
  if (f[1] < 0) f = opposite(f);
  node.contrast = 2 * static_cast<float>(corner.corner.contrast);
  node.along = {e, f, opposite(e), opposite(f)};
  const float u = e[0] + f[0], v = e[1] + f[1];
  const auto side = [&](const Direction& n) { return static_cast<float>(n.x) * u + static_cast<float>(n.y) * v > 0; };
  node.bright = side(corner.shape.n1) == side(corner.shape.n2);
  return node;
}

CornerLinks::CornerLinks(std::size_t max_corners) : max_nodes_(2 * max_corners) {
  nodes_.reserve(max_nodes_);
  candidates_.reserve(max_corners);
  gap_.reserve(max_corners);
  next_.reserve(max_nodes_);
  first_.reserve(3 * max_corners + 8);
}

void CornerLinks::build(std::span<const CornerFit> corners, const GrayView& image) {
  image_ = image;
  nodes_.clear();
  for (const CornerFit& corner : corners) nodes_.push_back(node_of(corner));
  candidates_.assign(nodes_.size(), {});
  gap_.assign(nodes_.size(), 0);
  sort_into_buckets();
  find_twins();
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (nodes_[i].usable) find_candidates(i);
  keep_mutual();
  find_cells();
}

int CornerLinks::column_of(float u) const {
  return std::clamp(static_cast<int>((u - origin_u_) / bucket_size_), 0, bucket_columns_ - 1);
}

int CornerLinks::row_of(float v) const {
  return std::clamp(static_cast<int>((v - origin_v_) / bucket_size_), 0, bucket_rows_ - 1);
}

// About one node a bucket over the rectangle that the nodes fill.
void CornerLinks::sort_into_buckets() {
  next_.assign(nodes_.size(), -1);
  first_.assign(1, -1);
  bucket_columns_ = bucket_rows_ = 1;
  if (nodes_.empty()) return;
  float u0 = nodes_[0].u, u1 = u0, v0 = nodes_[0].v, v1 = v0;
  for (const CornerNode& node : nodes_) {
    u0 = std::min(u0, node.u);
    u1 = std::max(u1, node.u);
    v0 = std::min(v0, node.v);
    v1 = std::max(v1, node.v);
  }
  const float n = static_cast<float>(nodes_.size());
  const float width = u1 - u0 + 1, height = v1 - v0 + 1;
  bucket_size_ = std::max({std::sqrt(width * height / n), width / n, height / n});
  origin_u_ = u0;
  origin_v_ = v0;
  bucket_columns_ = static_cast<int>(width / bucket_size_) + 1;
  bucket_rows_ = static_cast<int>(height / bucket_size_) + 1;
  // (w/s + 1)(h/s + 1) = n + (w + h)/s + 1 and each of w/s, h/s is at most n: 3 n + 1 at the most.
  first_.assign(static_cast<std::size_t>(bucket_columns_) * static_cast<std::size_t>(bucket_rows_), -1);
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    int& first = first_[static_cast<std::size_t>(row_of(nodes_[i].v) * bucket_columns_ + column_of(nodes_[i].u))];
    next_[i] = first;
    first = static_cast<int>(i);
  }
}

bool CornerLinks::add(const CornerNode& node) {
  if (nodes_.size() == max_nodes_) return false;
  int& first = first_[static_cast<std::size_t>(row_of(node.v) * bucket_columns_ + column_of(node.u))];
  next_.push_back(first);
  first = static_cast<int>(nodes_.size());
  nodes_.push_back(node);
  return true;
}

void CornerLinks::find_twins() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].usable) continue;
    const float u = nodes_[i].u, v = nodes_[i].v;
    near(u, v, kTwin, [&](std::size_t k) {
      if (k > i && std::hypot(nodes_[k].u - u, nodes_[k].v - v) < kTwin) nodes_[k].usable = false;
    });
  }
}

// In growing squares of buckets, until each half edge has one nearer than the square reaches.
void CornerLinks::find_candidates(std::size_t from) {
  const int column = column_of(nodes_[from].u), row = row_of(nodes_[from].v);
  const int most = std::max(bucket_columns_, bucket_rows_);
  int examined = 0;
  for (int ring = 0; ring < most && examined < kExamined; ++ring) {
    const auto look = [&](int r, int c) {
      if (r < 0 || c < 0 || r >= bucket_rows_ || c >= bucket_columns_) return;
      visit_bucket(r, c, [&](std::size_t to) {
        ++examined;
        consider(from, to);
      });
    };
    for (int c = column - ring; c <= column + ring; ++c) {
      look(row - ring, c);
      if (ring > 0) look(row + ring, c);
    }
    for (int r = row - ring + 1; r < row + ring; ++r) {
      look(r, column - ring);
      look(r, column + ring);
    }
    const float reached = static_cast<float>(ring) * bucket_size_;
    bool done = true;
    for (const Candidate& candidate : candidates_[from]) done = done && candidate.node >= 0 && candidate.cost <= reached;
    if (done) return;
  }
}

void CornerLinks::consider(std::size_t from, std::size_t to) {
  const CornerNode& a = nodes_[from];
  const CornerNode& b = nodes_[to];
  if (from == to || !b.usable) return;
  const float du = b.u - a.u, dv = b.v - a.v, length = std::hypot(du, dv);
  if (gap_[from] == 0 || length < gap_[from]) gap_[from] = length;
  const auto best_half = [&](const CornerNode& node, float sign, float& sine) {
    int best = 0;
    float most = -1;
    for (int i = 0; i < 4; ++i) {
      const auto& along = node.along[static_cast<std::size_t>(i)];
      const float cosine = sign * (along[0] * du + along[1] * dv);
      if (cosine > most) {
        most = cosine;
        best = i;
      }
    }
    const auto& along = node.along[static_cast<std::size_t>(best)];
    sine = std::abs(along[0] * dv - along[1] * du) / length;
    return best;
  };
  float sine_a, sine_b;
  const int half = best_half(a, 1, sine_a);
  if (sine_a > kCone) return;
  const int back = best_half(b, -1, sine_b);
  if (sine_b > kCone) return;
  // b's half edge i + turn is the continuation of a's i; an odd turn exchanges bright and dark sectors.
  const bool odd_turn = ((back - half) & 1) != 0;
  if ((b.bright != odd_turn) == a.bright) return;
  const float cost = length * (1 + 2 * (sine_a * sine_a + sine_b * sine_b));
  Candidate& best = candidates_[from][static_cast<std::size_t>(half)];
  if (best.node >= 0 && best.cost <= cost) return;
  best = {static_cast<int>(to), static_cast<std::int8_t>(back), cost};
}

void CornerLinks::keep_mutual() {
  for (std::size_t a = 0; a < nodes_.size(); ++a)
    for (std::size_t i = 0; i < 4; ++i) {
      const Candidate& there = candidates_[a][i];
      if (there.node < 0) continue;
      const Candidate& home = candidates_[static_cast<std::size_t>(there.node)][static_cast<std::size_t>(there.back)];
      if (home.node != static_cast<int>(a) || home.back != static_cast<int>(i)) continue;
      if (!edge_seen(nodes_[a], static_cast<int>(i), nodes_[static_cast<std::size_t>(there.node)])) continue;
      nodes_[a].link[i] = there.node;
      nodes_[a].back[i] = there.back;
    }
}

bool CornerLinks::edge_seen(const CornerNode& from, int half, const CornerNode& to) const {
  if (!sees_edges()) return true;
  const float du = to.u - from.u, dv = to.v - from.v, length = std::hypot(du, dv);
  const float beside = std::max(kBeside * length, 1.0f) / length, contrast = std::min(from.contrast, to.contrast);
  // Clockwise of half edge 0 lies the sector that from.bright tells of.
  const float sign = from.bright != ((half & 1) != 0) ? 1.0f : -1.0f;
  const auto level = [&](float u, float v) {
    const int cu = std::clamp(static_cast<int>(u), 0, image_.width - 2),
              cv = std::clamp(static_cast<int>(v), 0, image_.height - 2);
    const float fu = std::clamp(u - static_cast<float>(cu), 0.0f, 1.0f),
                fv = std::clamp(v - static_cast<float>(cv), 0.0f, 1.0f);
    const std::uint8_t *above = image_.row(cv) + cu, *below = image_.row(cv + 1) + cu;
    const float top = static_cast<float>(above[0]) * (1 - fu) + static_cast<float>(above[1]) * fu;
    const float bottom = static_cast<float>(below[0]) * (1 - fu) + static_cast<float>(below[1]) * fu;
    return top * (1 - fv) + bottom * fv;
  };
  float sum = 0;
  for (int k = 1; k <= kLooks; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(kLooks + 1);
    const float u = from.u + t * du, v = from.v + t * dv;
    const float differs = sign * (level(u - beside * dv, v + beside * du) - level(u + beside * dv, v - beside * du));
    if (differs < kMinDiffers * contrast) return false;
    sum += differs;
  }
  return sum >= kMeanDiffers * static_cast<float>(kLooks) * contrast;
}

void CornerLinks::find_cells() {
  for (std::size_t a = 0; a < nodes_.size(); ++a)
    for (int i = 0; i < 4; ++i)
      if (closes(a, i)) nodes_[a].cells = static_cast<std::uint8_t>(nodes_[a].cells | (1u << i));
}

// Along half edge i, then three right turns: back at the start, by the next half edge, round a convex cell.
bool CornerLinks::closes(std::size_t from, int half) const {
  std::array<std::size_t, 4> ring{};
  std::size_t at = from;
  int leave = half, arrived = 0;
  for (std::size_t side = 0; side < 4; ++side) {
    ring[side] = at;
    const CornerNode& node = nodes_[at];
    const int next = node.link[static_cast<std::size_t>(leave)];
    if (next < 0) return false;
    arrived = node.back[static_cast<std::size_t>(leave)];
    at = static_cast<std::size_t>(next);
    leave = (arrived + 3) % 4;
  }
  if (at != from || arrived != (half + 1) % 4) return false;
  std::array<float, 4> du{}, dv{}, length{};
  for (std::size_t i = 0; i < 4; ++i) {
    const CornerNode &a = nodes_[ring[i]], &b = nodes_[ring[(i + 1) % 4]];
    du[i] = b.u - a.u;
    dv[i] = b.v - a.v;
    length[i] = std::hypot(du[i], dv[i]);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    if (du[i] * dv[(i + 1) % 4] - dv[i] * du[(i + 1) % 4] <= 0) return false;
    if (length[i] > kSidesDiffer * length[(i + 2) % 4]) return false;
  }
  return true;
}

}  // namespace srd::dsp
