// SPDX-License-Identifier: Apache-2.0
// Every frame in the record, once and in order, over links and through deaths that a lab has.
#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "tests/fakes/scratch_folder.hpp"
#include "tests/host/delivery_simulation.hpp"

namespace srd::host {
namespace {

using simulated::kMillisecond;
using simulated::kSecond;
using simulated::Row;
using simulated::SimulatedNode;
using simulated::Simulation;

std::map<proto::BootId, std::vector<std::uint64_t>> by_boot(const Simulation& lab) {
  std::map<proto::BootId, std::vector<std::uint64_t>> out;
  for (const Row& row : lab.record) out[row.from].push_back(row.sequence);
  return out;
}

proto::BootId boot_of(const char* node, std::uint64_t boot) { return {*proto::NodeId::make(node), boot}; }

void expect_all_once_in_order(const std::vector<std::uint64_t>& sequences, std::uint64_t count) {
  ASSERT_EQ(sequences.size(), count);
  for (std::uint64_t i = 0; i < count; ++i) ASSERT_EQ(sequences[i], i);
}

simulated::LinkFaults bad_link() {
  return {.loss = 0.3, .duplication = 0.1, .least_delay = kMillisecond, .most_delay = 20 * kMillisecond};
}

void make_bad(SimulatedNode& node) { node.to_host.faults = node.to_node.faults = bad_link(); }

TEST(Delivery, SurvivesABadLinkWithinASecond) {
  Simulation lab;
  for (std::uint64_t i = 1; i <= 3; ++i) make_bad(lab.add_node("node-" + std::to_string(i), i));
  lab.start_host();
  lab.run(60 * kSecond);
  lab.end_nodes();
  const auto boots = by_boot(lab);
  ASSERT_EQ(boots.size(), 3u);
  for (std::uint64_t i = 1; i <= 3; ++i) {
    const SimulatedNode& node = *lab.nodes[i - 1];
    EXPECT_GE(node.captured, 12000u);
    expect_all_once_in_order(boots.at(boot_of(("node-" + std::to_string(i)).c_str(), i)), node.captured);
    EXPECT_EQ(node.sender.unacknowledged(), 0u);
    EXPECT_EQ(node.sender.counts().lost, 0u);
    // No flood: with 30 % loss both ways each frame needs 1/0.7 datagrams at least.
    EXPECT_LT(node.sender.counts().resent, node.captured);
  }
  std::vector<std::int64_t> delays;
  for (const Row& row : lab.record) delays.push_back(row.recorded_ns - row.captured_ns);
  std::sort(delays.begin(), delays.end());
  const std::int64_t at_999 = delays[delays.size() * 999 / 1000];
  RecordProperty("delay_ms_50", static_cast<int>(delays[delays.size() / 2] / kMillisecond));
  RecordProperty("delay_ms_999", static_cast<int>(at_999 / kMillisecond));
  RecordProperty("delay_ms_most", static_cast<int>(delays.back() / kMillisecond));
  RecordProperty("resent_per_frame_percent",
                 static_cast<int>(100 * lab.nodes[0]->sender.counts().resent / lab.nodes[0]->captured));
  EXPECT_LE(at_999, kSecond);
}

proto::Key a_key(std::uint8_t first) { return proto::Key(std::array<std::uint8_t, proto::Key::kBytes>{first}); }

firmware::SenderOptions with_key(std::uint8_t first) {
  firmware::SenderOptions options;
  options.key = a_key(first);
  return options;
}

TEST(DeliveryWithKeys, SurvivesABadLinkAndDeathsOfTheHostWithinASecond) {
  Simulation lab;
  lab.keys = {a_key(1)};
  for (std::uint64_t i = 1; i <= 3; ++i) make_bad(lab.add_node("n", i, with_key(1)));
  lab.start_host();
  lab.run(20 * kSecond);
  std::vector<std::int64_t> delays;
  for (const Row& row : lab.record) delays.push_back(row.recorded_ns - row.captured_ns);
  std::sort(delays.begin(), delays.end());
  EXPECT_LE(delays[delays.size() * 999 / 1000], kSecond);
  std::mt19937_64 random(7);
  for (int life = 0; life < 8; ++life) {
    lab.kill_host();
    lab.run(static_cast<std::int64_t>(random() % 1500) * kMillisecond);
    lab.start_host();
    lab.run(static_cast<std::int64_t>(random() % 3000) * kMillisecond);
  }
  lab.run(5 * kSecond);
  lab.end_nodes();
  const auto boots = by_boot(lab);
  for (std::uint64_t i = 1; i <= 3; ++i) {
    expect_all_once_in_order(boots.at(boot_of("n", i)), lab.nodes[i - 1]->captured);
    EXPECT_EQ(lab.nodes[i - 1]->sender.counts().lost, 0u);
  }
}

TEST(DeliveryWithKeys, AKeyIsChangedWithoutLosingAFrame) {
  Simulation lab;
  lab.keys = {a_key(1)};
  make_bad(lab.add_node("n", 1, with_key(1)));
  lab.start_host();
  lab.run(3 * kSecond);
  lab.keys = {a_key(2), a_key(1)};  // srd keygen --change: the host reads its folder again
  lab.run(3 * kSecond);
  lab.end_nodes();  // restarted with the new file
  make_bad(lab.add_node("n", 2, with_key(2)));
  lab.run(3 * kSecond);
  lab.keys = {a_key(2)};  // --end-change
  lab.run(3 * kSecond);
  lab.nodes[1]->capturing = false;
  lab.nodes[1]->sender.stop(lab.now);
  while (lab.nodes[1]->running) lab.step();
  const auto boots = by_boot(lab);
  ASSERT_EQ(boots.size(), 2u);
  for (std::uint64_t i = 1; i <= 2; ++i) expect_all_once_in_order(boots.at(boot_of("n", i)), lab.nodes[i - 1]->captured);
  EXPECT_GE(lab.nodes[0]->captured, 1200u);
}

TEST(DeliveryWithKeys, WithoutTheRightKeyNothingIsRecordedNorAcknowledged) {
  for (const bool node_has_one : {true, false}) {
    Simulation lab;
    lab.keys = {a_key(1)};
    SimulatedNode& node = lab.add_node("n", 1, node_has_one ? with_key(2) : firmware::SenderOptions{});
    lab.start_host();
    lab.run(3 * kSecond);
    EXPECT_TRUE(lab.record.empty());
    EXPECT_EQ(node.sender.counts().acknowledgements, 0u);
    EXPECT_TRUE(lab.host->receiver().sources().empty());
    ASSERT_EQ(lab.host->receiver().concerns().size(), 1u);
    EXPECT_EQ(lab.host->receiver().concerns()[0].second, node_has_one ? LinkConcern::kOtherKey : LinkConcern::kNodeKeyless);
  }
  Simulation lab;
  lab.add_node("n", 1, with_key(2));
  lab.start_host();
  lab.run(3 * kSecond);
  EXPECT_TRUE(lab.record.empty());
  ASSERT_EQ(lab.host->receiver().concerns().size(), 1u);
  EXPECT_EQ(lab.host->receiver().concerns()[0].second, LinkConcern::kHostKeyless);
}

// Nodes die at any moment, one after the other under one id, and the host too; what each had numbered is in the record.
TEST(DeliveryWithSpill, NodesAndHostKilledAtRandomLoseNothing) {
  const fakes::ScratchFolder folder;
  Simulation lab;
  lab.spill_folder = folder.path();
  lab.keys = {a_key(1)};
  std::mt19937_64 random(11);
  lab.start_host();
  constexpr std::uint64_t kLives = 25;
  for (std::uint64_t life = 1; life <= kLives; ++life) {
    firmware::SenderOptions options = with_key(1);
    options.ring_frames = 2000;
    SimulatedNode& node = lab.add_node("n", life, options);
    make_bad(node);
    lab.run(static_cast<std::int64_t>(random() % 2000) * kMillisecond);
    if (random() % 2 == 0) {
      lab.kill_host();
      lab.run(static_cast<std::int64_t>(random() % 1000) * kMillisecond);
      if (life < kLives) Simulation::kill_node(node);
      lab.start_host();
    } else if (life < kLives) {
      Simulation::kill_node(node);
    }
    lab.run(static_cast<std::int64_t>(random() % 300) * kMillisecond);
  }
  lab.run(10 * kSecond);
  EXPECT_TRUE(lab.nodes.back()->old.empty());
  EXPECT_TRUE(lab.host->receiver().shared_ids().empty());
  lab.end_nodes();
  const auto boots = by_boot(lab);
  for (std::uint64_t i = 1; i <= kLives; ++i) {
    const std::uint64_t captured = lab.nodes[i - 1]->captured;
    if (captured == 0 && !boots.contains(boot_of("n", i))) continue;
    expect_all_once_in_order(boots.at(boot_of("n", i)), captured);
  }
  // Only the last run's file is there, and it ended with everything acknowledged.
  EXPECT_EQ(lab.nodes.back()->sender.unacknowledged(), 0u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

// A ring that was full when the node died: what it had overwritten is named, under the old boot.
TEST(DeliveryWithSpill, WhatTheRingHadOverwrittenIsNamed) {
  const fakes::ScratchFolder folder;
  Simulation lab;
  lab.spill_folder = folder.path();
  firmware::SenderOptions options;
  options.ring_frames = 300;
  SimulatedNode& first = lab.add_node("n", 1, options);
  lab.run(5 * kSecond);
  const std::uint64_t captured = first.captured;
  Simulation::kill_node(first);
  lab.start_host();
  lab.add_node("n", 2, options);
  lab.run(3 * kSecond);
  const auto boots = by_boot(lab);
  const auto& rows = boots.at(boot_of("n", 1));
  ASSERT_EQ(rows.size(), 300u);
  EXPECT_EQ(rows.front(), captured - 300);
  EXPECT_EQ(rows.back(), captured - 1);
  const auto& stream = lab.host->receiver().sources().at(boot_of("n", 1)).stream;
  ASSERT_EQ(stream.lost_ranges().size(), 1u);
  EXPECT_EQ(stream.lost_ranges()[0], (proto::SequenceRange{0, captured - 300}));
}

// Earlier runs' frames while the host was away, more runs than are kept: the oldest are given up, and told of.
TEST(DeliveryWithSpill, KeepsSoManyEarlierRuns) {
  const fakes::ScratchFolder folder;
  Simulation lab;
  lab.spill_folder = folder.path();
  firmware::SenderOptions options;
  options.ring_frames = 300;
  for (std::uint64_t life = 1; life <= 12; ++life) {
    SimulatedNode& node = lab.add_node("n", life, options);
    lab.run(100 * kMillisecond);
    Simulation::kill_node(node);
  }
  lab.start_host();
  const SimulatedNode& node = lab.add_node("n", 13, options);
  EXPECT_NE(node.old.summary().find("of 8 earlier runs"), std::string::npos) << node.old.summary();
  EXPECT_NE(node.old.summary().find("are given up"), std::string::npos) << node.old.summary();
  lab.run(5 * kSecond);
  EXPECT_EQ(by_boot(lab).size(), 9u);
  EXPECT_LE(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

// A stranger who hears everything, and has the key of a node "mine" only, sends a million datagrams to the host and to the
// node: what was said before, also in another session and of another boot, to the other end, cut, changed, made with the key
// that it has, and noise.
TEST(SlowDeliveryWithKeys, NothingOfAMillionForgedDatagramsIsAccepted) {
  Simulation lab;
  lab.keys = {a_key(1)};
  std::vector<std::vector<std::uint8_t>> heard;
  std::mt19937_64 random(5);
  lab.overheard = [&](bool, const std::vector<std::uint8_t>& datagram) {
    if (heard.size() < 20000) heard.push_back(datagram);
  };
  lab.add_node("n", 1, with_key(1));
  lab.start_host();
  lab.run(4 * kSecond);
  lab.end_nodes();
  lab.kill_host();
  lab.start_host();
  SimulatedNode& node = lab.add_node("n", 2, with_key(1));
  lab.run(4 * kSecond);
  const proto::Key mine = a_key(9);
  std::map<proto::BootId, std::uint64_t> recorded;
  std::uint64_t forged = 0, rows = lab.record.size();
  const auto address = Address::parse("127.0.0.1:9", "stranger").value();
  while (forged < 1'000'000) {
    auto datagram = heard[random() % heard.size()];
    switch (random() % 5) {
      case 0: break;  // replayed
      case 1: datagram.resize(random() % datagram.size()); break;
      case 2: datagram[random() % datagram.size()] ^= static_cast<std::uint8_t>(1 + random() % 255); break;
      case 3: {  // the stranger's own tag
        const auto direction = random() % 2 == 0 ? proto::Direction::kFromNode : proto::Direction::kFromHost;
        const std::size_t size = datagram.size() - std::min(datagram.size(), proto::kMostEndBytes);
        datagram.resize(size + proto::kMostEndBytes);
        proto::append_end(&mine, direction, datagram, size);
        break;
      }
      default:
        for (auto& byte : datagram) byte = static_cast<std::uint8_t>(random());
    }
    // Both ends get it: half of what was heard is reflected.
    lab.host->receive(datagram, address);
    const auto before = node.sender.counts();
    const std::uint64_t unacknowledged = node.sender.unacknowledged();
    node.sender.receive(datagram, lab.now);
    ASSERT_EQ(node.sender.counts().acknowledgements, before.acknowledgements);
    ASSERT_EQ(node.sender.unacknowledged(), unacknowledged);
    forged += 2;
    if (forged % 2000 == 0) lab.step();  // life goes on
    for (const auto& [id, source] : lab.host->receiver().sources()) ASSERT_FALSE(source.address == address);
  }
  ASSERT_TRUE(lab.host->receiver().sources().size() <= 2u);
  EXPECT_LE(lab.host->receiver().concerns().size(), Receiver::kMaxConcerns);
  lab.run(kSecond);
  EXPECT_GT(lab.record.size(), rows);
  node.capturing = false;
  node.sender.stop(lab.now);
  while (node.running) lab.step();
  const auto boots = by_boot(lab);
  ASSERT_EQ(boots.size(), 2u);
  for (std::uint64_t i = 1; i <= 2; ++i) expect_all_once_in_order(boots.at(boot_of("n", i)), lab.nodes[i - 1]->captured);
  EXPECT_EQ(node.sender.counts().lost, 0u);
}

TEST(Delivery, GoodLinkSendsEachFrameOnce) {
  Simulation lab;
  SimulatedNode& node = lab.add_node("n", 1);
  lab.start_host();
  lab.run(20 * kSecond);
  lab.end_nodes();
  lab.run(100 * kMillisecond);  // the goodbye is under way
  expect_all_once_in_order(by_boot(lab).at(boot_of("n", 1)), node.captured);
  EXPECT_EQ(node.sender.counts().resent, 0u);
  EXPECT_EQ(lab.host->receiver().sources().begin()->second.stream.counts().duplicates, 0u);
  EXPECT_TRUE(lab.host->receiver().sources().begin()->second.ended);
}

TEST(Delivery, NothingIsLostWhenTheLinkIsAwayForAMinute) {
  Simulation lab;
  SimulatedNode& node = lab.add_node("n", 1, {.ring_frames = 15000, .ring_bytes = 8 << 20});
  make_bad(node);
  lab.start_host();
  lab.run(5 * kSecond);
  node.to_host.faults.away = node.to_node.faults.away = true;
  const std::uint64_t sent_before = node.sender.counts().datagrams;
  lab.run(60 * kSecond);
  const std::uint64_t sent_away = node.sender.counts().datagrams - sent_before;
  RecordProperty("datagrams_per_second_while_away", static_cast<int>(sent_away / 60));
  EXPECT_LT(sent_away, 60 * 400u);  // not a flood
  node.to_host.faults.away = node.to_node.faults.away = false;
  const std::int64_t back = lab.now;
  while (lab.record.size() + 100 < node.captured) {
    lab.step();
    ASSERT_LT(lab.now, back + 60 * kSecond);
  }
  RecordProperty("seconds_to_catch_up", static_cast<int>((lab.now - back) / kSecond));
  lab.run(5 * kSecond);
  lab.end_nodes();
  expect_all_once_in_order(by_boot(lab).at(boot_of("n", 1)), node.captured);
  EXPECT_EQ(node.sender.counts().lost, 0u);
}

TEST(Delivery, NothingIsLostWhenTheHostIsKilledAndRestarted) {
  Simulation lab;
  for (std::uint64_t i = 1; i <= 3; ++i) make_bad(lab.add_node("n", i));
  std::mt19937_64 random(7);
  for (int life = 0; life < 12; ++life) {
    lab.start_host();
    lab.run(static_cast<std::int64_t>(random() % 3000) * kMillisecond);
    lab.kill_host();
    lab.run(static_cast<std::int64_t>(random() % 1500) * kMillisecond);
  }
  lab.start_host();
  lab.run(5 * kSecond);
  lab.end_nodes();
  const auto boots = by_boot(lab);
  for (std::uint64_t i = 1; i <= 3; ++i) expect_all_once_in_order(boots.at(boot_of("n", i)), lab.nodes[i - 1]->captured);
}

// The camera has stopped: only the node's status tells the new host that there is something to fetch.
TEST(Delivery, ANewHostFetchesWhatTheOldOneHadInMemoryOnly) {
  Simulation lab;
  SimulatedNode& node = lab.add_node("n", 1);
  lab.start_host();
  lab.run(kSecond);
  // The first frame after this is lost, so all later ones wait in the host's memory.
  node.to_host.faults.away = true;
  lab.run(6 * kMillisecond);
  node.to_host.faults.away = false;
  for (int i = 0; i < 20; ++i) lab.step();
  node.capturing = false;
  lab.kill_host();
  lab.run(3 * kSecond);
  lab.start_host();
  lab.run(3 * kSecond);
  expect_all_once_in_order(by_boot(lab).at(boot_of("n", 1)), node.captured);
}

TEST(Delivery, NodeThatEndsNormallyLeavesNothingBehind) {
  for (std::uint64_t run = 0; run < 20; ++run) {
    Simulation lab;
    SimulatedNode& node = lab.add_node("n", run);
    make_bad(node);
    lab.start_host();
    lab.run(500 * kMillisecond);
    const std::int64_t stopped = lab.now;
    lab.end_nodes();
    EXPECT_LT(lab.now - stopped, 5 * kSecond);
    lab.run(100 * kMillisecond);
    expect_all_once_in_order(by_boot(lab).at(boot_of("n", run)), node.captured);
  }
}

TEST(Delivery, LingersFiveSecondsForAnAbsentHost) {
  Simulation lab;
  lab.add_node("n", 1);
  lab.run(kSecond);
  const std::int64_t stopped = lab.now;
  lab.end_nodes();
  EXPECT_GE(lab.now - stopped, 5 * kSecond);
  EXPECT_LE(lab.now - stopped, 5 * kSecond + 10 * kMillisecond);
  EXPECT_GT(lab.nodes[0]->sender.unacknowledged(), 0u);
}

TEST(Delivery, NamesTheRangeThatAFullRingLost) {
  Simulation lab;
  SimulatedNode& node = lab.add_node("n", 1, {.ring_frames = 1000});
  lab.start_host();
  lab.run(2 * kSecond);
  const std::uint64_t before = lab.record.size();
  node.to_host.faults.away = node.to_node.faults.away = true;
  lab.run(20 * kSecond);  // 4000 frames, 1000 fit
  node.to_host.faults.away = node.to_node.faults.away = false;
  lab.run(10 * kSecond);
  lab.end_nodes();
  const Stream& stream = lab.host->receiver().sources().begin()->second.stream;
  ASSERT_EQ(stream.lost_ranges().size(), 1u);
  const proto::SequenceRange lost = stream.lost_ranges()[0];
  EXPECT_GE(lost.begin, before - 10);
  EXPECT_NEAR(static_cast<double>(lost.size()), 3000, 100);
  EXPECT_EQ(stream.counts().lost, lost.size());
  // The node cannot know that the host has the frames whose acknowledgement did not come through.
  EXPECT_GE(node.sender.counts().lost, lost.size());
  EXPECT_LE(node.sender.counts().lost, lost.size() + 20);
  // All others are there, once and in order.
  const auto sequences = by_boot(lab).at(boot_of("n", 1));
  ASSERT_EQ(sequences.size() + lost.size(), node.captured);
  for (std::uint64_t i = 0; i < sequences.size(); ++i) ASSERT_EQ(sequences[i], i < lost.begin ? i : i + lost.size());
}

TEST(Delivery, NamesLostFramesToAHostThatStartsLater) {
  Simulation lab;
  lab.add_node("n", 1, {.ring_frames = 100});
  lab.run(3 * kSecond);
  lab.start_host();
  lab.run(3 * kSecond);
  const Stream& stream = lab.host->receiver().sources().begin()->second.stream;
  ASSERT_EQ(stream.lost_ranges().size(), 1u);
  EXPECT_EQ(stream.lost_ranges()[0].begin, 0u);
  EXPECT_NEAR(static_cast<double>(stream.lost_ranges()[0].end), 500, 20);
}

TEST(Delivery, KilledNodeThatReturnsHasItsMissingTailNamed) {
  Simulation lab;
  SimulatedNode& first = lab.add_node("n", 1);
  lab.start_host();
  lab.run(kSecond);
  // Ten frames stay on the way, later ones come through; then the node dies.
  first.to_host.faults.away = true;
  lab.run(20 * kMillisecond);
  first.to_host.faults.away = false;
  lab.run(10 * kMillisecond);
  first.running = false;
  lab.add_node("n", 2);
  lab.run(10 * kSecond);
  const auto& sources = lab.host->receiver().sources();
  const Stream& stream = sources.at(boot_of("n", 1)).stream;
  EXPECT_EQ(stream.waiting(), 0u);
  ASSERT_EQ(stream.lost_ranges().size(), 1u);
  EXPECT_EQ(stream.lost_ranges()[0].end - stream.lost_ranges()[0].begin, stream.counts().lost);
  EXPECT_EQ(by_boot(lab).at(boot_of("n", 1)).back() + 1, stream.counts().delivered + stream.counts().lost);
}

TEST(Delivery, SourceThatCanWaitIsHeldBackInsteadOfLosingFrames) {
  Simulation lab;
  SimulatedNode& node = lab.add_node("n", 1, {.ring_frames = 50, .overwrite = false});
  node.capturing = false;
  lab.start_host();
  std::uint64_t pushed = 0, waited = 0;
  while (pushed < 5000) {
    if (node.sender.full())
      ++waited;
    else
      for (int i = 0; i < 10 && !node.sender.full(); ++i, ++pushed)
        ASSERT_TRUE(node.sender.push(Simulation::frame_at(lab.now)));
    lab.step();
  }
  lab.end_nodes();
  EXPECT_GT(waited, 0u);
  EXPECT_EQ(node.sender.counts().lost, 0u);
  expect_all_once_in_order(by_boot(lab).at(boot_of("n", 1)), pushed);
}

}  // namespace
}  // namespace srd::host
