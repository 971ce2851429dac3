// SPDX-License-Identifier: Apache-2.0
#include "host/listen/record_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <random>

#include "host/coefficients/row_writer.hpp"
#include "host/listen/once.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/proto/random_messages.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

std::int64_t wall() {
  static std::int64_t now = 1'700'000'000'000'000'000;
  return now += 1000;
}

proto::BootId boot_of(const char* node, std::uint64_t boot) { return {*proto::NodeId::make(node), boot}; }

// The frame that a boot gives this number.
proto::CoefficientFrame frame_of(const proto::BootId& from, std::uint64_t sequence) {
  proto::testing::Generator random(from.boot * 1000 + sequence);
  return proto::testing::any_frame(random);
}

std::string row_of(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  std::string row;
  append_row(row_content(from, sequence, frame), row);
  return row;
}

using Record = std::map<proto::BootId, std::map<std::uint64_t, std::string>>;  // rows; each number once

Record read(const fs::path& folder) {
  Record out;
  const auto done = RecordFolder::read(folder, [&](const proto::BootId& from, std::uint64_t sequence, const auto& frame) {
    EXPECT_TRUE(out[from].emplace(sequence, row_of(from, sequence, frame)).second) << "twice";
  });
  EXPECT_TRUE(done.ok()) << done.error().text();
  return out;
}

void write(RecordFolder& record, const proto::BootId& from, std::uint64_t begin, std::uint64_t end,
           std::uint64_t flush_every = 7) {
  for (std::uint64_t s = begin; s < end; ++s) {
    ASSERT_TRUE(record.write(from, s, frame_of(from, s)).ok());
    if (s % flush_every == 0) {
      ASSERT_TRUE(record.flush().ok());
    }
  }
  ASSERT_TRUE(record.flush().ok());
}

std::unique_ptr<RecordFolder> opened(const fs::path& folder, std::uint64_t segment_bytes = RecordFolder::kSegmentBytes) {
  auto made = RecordFolder::open(folder, wall, segment_bytes);
  EXPECT_TRUE(made.ok()) << made.error().text();
  return std::move(*made);
}

TEST(RecordFolder, GivesBackEveryNumberOfEveryFrame) {
  const fakes::ScratchFolder folder;
  const proto::BootId a = boot_of("cam-1", 1), b = boot_of("cam-2", 2);
  {
    const auto record = opened(folder.path() / "rec", 100'000);
    write(*record, a, 0, 300);
    write(*record, b, 50, 250);
    write(*record, a, 300, 400);
  }
  EXPECT_GT(std::distance(fs::directory_iterator(folder.path() / "rec"), {}), 2) << "segments";
  const Record record = read(folder.path() / "rec");
  ASSERT_EQ(record.size(), 2u);
  ASSERT_EQ(record.at(a).size(), 400u);
  ASSERT_EQ(record.at(b).size(), 200u);
  for (const auto& [from, rows] : record)
    for (const auto& [sequence, row] : rows) ASSERT_EQ(row, row_of(from, sequence, frame_of(from, sequence)));
}

// As when the process dies: no end, no index.
TEST(RecordFolder, TheNextRunGoesOnInANewSegmentWithoutADoubleFrame) {
  const fakes::ScratchFolder folder;
  const auto rec = folder.path() / "rec", copy = folder.path() / "copy";
  const proto::BootId from = boot_of("n", 1);
  const auto record = opened(rec);
  write(*record, from, 0, 100);
  fs::copy(rec, copy, fs::copy_options::recursive);  // and the first one lives on
  for (std::uint64_t run = 1; run <= 3; ++run) {
    const auto again = opened(copy);
    ASSERT_EQ(again->frames_in_file().at(from).first_missing(0), 100 * run);
    write(*again, from, 100 * run, 100 * (run + 1));
  }
  EXPECT_EQ(read(copy).at(from).size(), 400u);
  EXPECT_EQ(std::distance(fs::directory_iterator(copy), {}), 4);
}

TEST(SlowRecordFolder, CutAtAnyByteGivesTheWholeFramesBeforeAndNoOther) {
  const fakes::ScratchFolder folder;
  const proto::BootId from = boot_of("n", 1);
  { write(*opened(folder.path() / "rec"), from, 0, 200, 3); }
  const std::string whole = fakes::bytes_of(folder.path() / "rec/000001.mcap");
  std::mt19937_64 random(1);
  std::size_t last_cut = 0, last_frames = 0;
  std::vector<std::size_t> cuts;
  for (int i = 0; i < 1000; ++i) cuts.push_back(random() % (whole.size() + 1));
  std::sort(cuts.begin(), cuts.end());
  for (const std::size_t cut : cuts) {
    std::ofstream(folder.path() / "rec/000001.mcap", std::ios::binary | std::ios::trunc)
        .write(whole.data(), static_cast<std::streamsize>(cut));
    std::uint64_t next = 0;
    const auto done = RecordFolder::read(folder.path() / "rec", [&](const auto& of, std::uint64_t sequence, const auto& frame) {
      ASSERT_EQ(of, from);
      ASSERT_EQ(sequence, next++);
      if (cut % 16 == 0) {
        ASSERT_EQ(row_of(of, sequence, frame), row_of(from, sequence, frame_of(from, sequence)));
      }
    });
    ASSERT_TRUE(done.ok());
    ASSERT_GE(next, last_frames) << cut;
    // No more than one chunk is behind the cut.
    if (cut - last_cut < 400) {
      ASSERT_LE(next, last_frames + 6);
    }
    last_cut = cut;
    last_frames = next;
  }
  EXPECT_GE(last_frames, 190u);
}

TEST(RecordFolder, DamageNeverGivesAWrongFrame) {
  const fakes::ScratchFolder folder;
  const proto::BootId from = boot_of("n", 1);
  { write(*opened(folder.path() / "rec"), from, 0, 60); }
  const std::string whole = fakes::bytes_of(folder.path() / "rec/000001.mcap");
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    std::string bad = whole;
    for (auto hits = 1 + random() % 5; hits > 0; --hits) bad[random() % bad.size()] ^= static_cast<char>(1 << (random() % 8));
    std::ofstream(folder.path() / "rec/000001.mcap", std::ios::binary | std::ios::trunc) << bad;
    (void)RecordFolder::read(folder.path() / "rec", [&](const auto& of, std::uint64_t sequence, const auto& frame) {
      ASSERT_EQ(of, from);
      ASSERT_EQ(row_of(of, sequence, frame), row_of(from, sequence, frame_of(from, sequence)));
    });
  }
}

TEST(RecordFolder, RefusesASegmentThatIsNone) {
  const fakes::ScratchFolder folder;
  folder.write("rec/000001.mcap", "node,boot,sequence\n");
  const auto refused = RecordFolder::open(folder.path() / "rec", wall);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().exit, Exit::kInput);
  EXPECT_NE(refused.error().text().find("000001.mcap"), std::string::npos);
}

// By the format's own library, which is not part of Debian: SRD_MCAP_CORE names a folder where "npm install @mcap/core" was run.
TEST(RecordFolder, IsReadByTheFormatsOwnLibrary) {
  const char* library = std::getenv("SRD_MCAP_CORE");
  if (library == nullptr) GTEST_SKIP() << "SRD_MCAP_CORE names no folder with @mcap/core";
  const fakes::ScratchFolder folder;
  const proto::BootId a = boot_of("cam-1", 1), b = boot_of("cam-2", 2);
  {
    const auto record = opened(folder.path() / "rec");
    write(*record, a, 0, 100);
    write(*record, b, 0, 50);
  }
  const std::string whole = fakes::bytes_of(folder.path() / "rec/000001.mcap");
  folder.write("cut.mcap", std::string_view(whole).substr(0, whole.size() * 2 / 3));
  folder.write("read.js", R"(
const {McapIndexedReader, McapStreamReader} = require(process.env.SRD_MCAP_CORE + "/node_modules/@mcap/core");
const fs = require("fs");
(async () => {
  const file = fs.readFileSync(process.argv[2]);
  const readable = {size: async () => BigInt(file.length),
                    read: async (at, size) => new Uint8Array(file.subarray(Number(at), Number(at + size)))};
  const reader = await McapIndexedReader.Initialize({readable});
  const topics = {};
  for await (const message of reader.readMessages()) {
    const topic = reader.channelsById.get(message.channelId).topic;
    topics[topic] = (topics[topic] ?? 0) + 1;
  }
  const schema = [...reader.schemasById.values()][0];
  const streamed = new McapStreamReader({validateCrcs: true});
  streamed.append(fs.readFileSync(process.argv[3]));
  let whole = 0;
  for (let record; (record = streamed.nextRecord());) whole += record.type === "Message" ? 1 : 0;
  console.log(JSON.stringify(topics), Number(reader.statistics.messageCount), schema.name, schema.encoding, whole > 80 && whole < 150);
})().catch((error) => { console.log(error); process.exit(1); });
)");
  const std::string out = (folder.path() / "said").string();
  const std::string command = "node '" + (folder.path() / "read.js").string() + "' '" +
                              (folder.path() / "rec/000001.mcap").string() + "' '" + (folder.path() / "cut.mcap").string() +
                              "' >'" + out + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << fakes::bytes_of(out);
  EXPECT_EQ(fakes::bytes_of(out), "{\"/cam-1\":100,\"/cam-2\":50} 150 srd.wire.NodeDatagram protobuf true\n");
}

// Two sinks that died at different frames: each gets what it lacks, and nothing twice.
TEST(Once, GivesASinkOnlyWhatItHasNot) {
  struct Sink final : FrameSink {
    std::vector<std::uint64_t> got;
    Outcome<void> write(const proto::BootId&, std::uint64_t sequence, const proto::CoefficientFrame&) override {
      got.push_back(sequence);
      return {};
    }
    Outcome<void> flush() override { return {}; }
  } sink;
  const proto::BootId from = boot_of("n", 1), other = boot_of("n", 2);
  SequenceSet has;
  has.add({0, 5});
  has.add({7, 9});
  Once once(sink, {{from, has}});
  for (std::uint64_t s = 0; s < 10; ++s) ASSERT_TRUE(once.write(from, s, {}).ok());
  EXPECT_EQ(sink.got, (std::vector<std::uint64_t>{5, 6, 9}));
  ASSERT_TRUE(once.write(other, 0, {}).ok());
  EXPECT_EQ(sink.got.size(), 4u);
  SequenceSet second;
  second.add({3, 8});
  const auto both = in_both({{from, has}, {other, has}}, {{from, second}});
  ASSERT_EQ(both.size(), 1u);
  EXPECT_EQ(both.at(from).ranges(), (std::vector<proto::SequenceRange>{{3, 5}, {7, 8}}));
}

}  // namespace
}  // namespace srd::host
