// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "drivers/recording/truth.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using fakes::bytes_of;
using fakes::ScratchFolder;

GrayImage test_image(int width, int height, unsigned seed) {
  GrayImage image{std::vector<std::uint8_t>(static_cast<std::size_t>(width * height)), width, height};
  std::mt19937 random(seed);
  for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random());
  return image;
}

const std::string kHeader = "file,sequence,time_ns,exposure_us,strobe\n";

TEST(Recording, ComesBackAsWritten) {
  for (const ImageFormat format : {ImageFormat::kPng, ImageFormat::kPgm}) {
    const ScratchFolder folder;
    auto writer = RecordingWriter::create(folder.path() / "run", format, false);
    ASSERT_TRUE(writer) << writer.error().text();
    std::vector<RecordedFrame> frames;
    for (unsigned i = 0; i < 5; ++i) {
      frames.push_back({"", 7 + 3 * i, -50 + 20'000'001LL * i, 150 * i, static_cast<StrobePhase>(i % 3)});
      ASSERT_TRUE(writer->add(test_image(33, 17, i).view(), frames.back()));
    }
    const auto read = read_recording(folder.path() / "run");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_TRUE(read->listed);
    EXPECT_FALSE(read->cut);
    ASSERT_EQ(read->frames.size(), frames.size());
    for (unsigned i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(read->frames[i].sequence, frames[i].sequence);
      EXPECT_EQ(read->frames[i].time_ns, frames[i].time_ns);
      EXPECT_EQ(read->frames[i].exposure_us, frames[i].exposure_us);
      EXPECT_EQ(read->frames[i].strobe, frames[i].strobe);
      const auto image = read_gray_image(read->folder / read->frames[i].file);
      ASSERT_TRUE(image) << image.error().text();
      EXPECT_EQ(image->pixels, test_image(33, 17, i).pixels);
    }
  }
}

TEST(Recording, IsNotOverwrittenUnlessToldTo) {
  const ScratchFolder folder;
  ASSERT_TRUE(RecordingWriter::create(folder.path(), ImageFormat::kPgm, false));
  const auto again = RecordingWriter::create(folder.path(), ImageFormat::kPgm, false);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().exit, Exit::kUsage);
  EXPECT_TRUE(RecordingWriter::create(folder.path(), ImageFormat::kPgm, true));
}

TEST(Recording, CutAtAnyByteIsReadableToItsLastWholeFrame) {
  const ScratchFolder folder;
  const std::string rows[] = {"frame_0.png,0,0,100,0\n", "frame_1.png,1,20000000,100,1\n", "frame_2.png,2,40000000,1005,2\n"};
  std::string whole = kHeader;
  for (const auto& row : rows) whole += row;
  for (std::size_t cut = kHeader.size(); cut <= whole.size(); ++cut) {
    folder.write("frames.csv", whole.substr(0, cut));
    std::size_t expected = 0;
    for (std::size_t end = kHeader.size(); const auto& row : rows) {
      end += row.size();
      if (cut + 1 >= end) ++expected;  // a row that only lacks its line end is whole
    }
    const auto read = read_recording(folder.path());
    if (expected == 0) {
      EXPECT_FALSE(read);
      continue;
    }
    ASSERT_TRUE(read) << cut << read.error().text();
    EXPECT_EQ(read->frames.size(), expected) << cut;
    EXPECT_EQ(read->frames.back().exposure_us, expected == 3 ? 1005U : 100U);
  }
}

TEST(Recording, WrongListingsAreRefusedWithTheirLine) {
  const ScratchFolder folder;
  const struct {
    std::string contents, in_text;
  } cases[] = {
      {"", ":1"},
      {"file,time\na.png,0\n", ":1"},
      {kHeader, "no whole frame"},
      {kHeader + "a.png,0,0,0,3\n", ":2"},
      {kHeader + "a.png,0,0,0\n", ":2"},
      {kHeader + "a.png,0,0,0,0,0\n", ":2"},
      {kHeader + ",0,0,0,0\n", ":2"},
      {kHeader + "a.png,-1,0,0,0\n", ":2"},
      {kHeader + "a.png,0,1.5,0,0\n", ":2"},
      {kHeader + "a.png,0,0,4294967296,0\n", ":2"},
      {kHeader + "a.png,0,9223372036854775808,0,0\n", ":2"},
      {kHeader + "/etc/a.png,0,0,0,0\n", ":2"},
      {kHeader + "../a.png,0,0,0,0\n", ":2"},
      {kHeader + "b/../../a.png,0,0,0,0\n", ":2"},
      {kHeader + "a.png,5,0,0,0\n\nb.png,5,1,0,0\n", ":4: 'sequence'"},
      {kHeader + "a.png,5,10,0,0\nb.png,6,9,0,0\n", ":3: 'time_ns'"},
  };
  for (const auto& wrong : cases) {
    folder.write("frames.csv", wrong.contents);
    const auto read = read_recording(folder.path());
    ASSERT_FALSE(read) << wrong.contents;
    EXPECT_NE(read.error().text().find(wrong.in_text), std::string::npos) << read.error().text();
  }
  EXPECT_FALSE(read_recording(folder.path() / "none"));
  EXPECT_FALSE(read_recording(folder.path() / "frames.csv"));
}

TEST(Recording, ImagesWithoutListingComeInNaturalOrderAtTheGivenRate) {
  const ScratchFolder folder;
  for (const char* name : {"frame_10.png", "frame_2.png", "frame_1.PNG", "frame_02.png", "notes.txt", "reference.png",
                           "._frame_1.png", ".frame_0.png"})
    folder.write(name, "x");
  std::filesystem::create_directory(folder.path() / "frame_3.png");
  const auto read = read_recording(folder.path(), {30});
  ASSERT_TRUE(read) << read.error().text();
  std::vector<std::string> names;
  for (const auto& frame : read->frames) names.push_back(frame.file);
  EXPECT_EQ(names, (std::vector<std::string>{"frame_1.PNG", "frame_02.png", "frame_2.png", "frame_10.png"}));
  EXPECT_FALSE(read->listed);
  EXPECT_EQ(read->frames[1].time_ns, 33'333'333);
  EXPECT_EQ(read->frames[3].time_ns, 100'000'000);
  for (const double rate : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const auto without = read_recording(folder.path(), {rate});
    ASSERT_FALSE(without);
    EXPECT_EQ(without.error().exit, Exit::kUsage);
  }
}

TEST(Recording, ClockThatWasSetBackIsRefusedUntilARateGivesTheTimes) {
  const ScratchFolder folder;
  folder.write("frames.csv",
               std::string(kFramesHeader) + "\na.png,7,5000000000,0,0\nb.png,8,5040000000,0,0\nc.png,11,1000,0,1\n");
  const auto refused = read_recording(folder.path(), {25});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().exit, Exit::kInput);
  for (const char* part : {"frames.csv:4", "'time_ns' falls", "--rate HZ"})
    EXPECT_NE(refused.error().text().find(part), std::string::npos) << refused.error().text();
  const auto read = read_recording(folder.path(), {25, true});
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->frames.size(), 3U);
  EXPECT_EQ(read->frames[0].time_ns, 0);
  EXPECT_EQ(read->frames[1].time_ns, 40'000'000);
  EXPECT_EQ(read->frames[2].time_ns, 160'000'000) << "frames that the source lost take their time";
  EXPECT_EQ(read->frames[2].sequence, 11U);
  EXPECT_EQ(read->frames[2].strobe, StrobePhase::kLit);
  ASSERT_EQ(read->notes.size(), 1U);
  EXPECT_NE(read->notes[0].find("25 Hz"), std::string::npos) << read->notes[0];
  for (const double rate : {0.0, std::nan(""), 1e-12}) {
    const auto wrong = read_recording(folder.path(), {rate, true});
    ASSERT_FALSE(wrong) << rate;
    EXPECT_EQ(wrong.error().exit, Exit::kUsage);
  }
}

TEST(ImageFile, HeadersThatClaimTooMuchAreRefused) {
  const ScratchFolder folder;
  folder.write("big.pgm", "P5 65000 65000 255\nabc");
  EXPECT_FALSE(read_gray_image(folder.path() / "big.pgm"));
}

TEST(ImageFile, TenBitsAreShiftedToEight) {
  const ScratchFolder folder;
  folder.write("ten.pgm", std::string("P5\n# ten bits\n2 1\n1023\n\x03\xFF\x00\x07", 28));
  const auto ten = read_gray_image(folder.path() / "ten.pgm");
  ASSERT_TRUE(ten);
  EXPECT_EQ(ten->pixels, (std::vector<std::uint8_t>{255, 1}));
}

std::string wide_pgm(const std::vector<int>& samples, int maximum) {
  std::string text = "P5\n" + std::to_string(samples.size()) + " 1\n" + std::to_string(maximum) + "\n";
  for (const int sample : samples) {
    text += static_cast<char>(sample >> 8);
    text += static_cast<char>(sample & 255);
  }
  return text;
}

TEST(ImageFile, SamplesAtTheLowerEndAreToldAndReadByTheirBits) {
  const ScratchFolder folder;
  const auto file = folder.path() / "a.pgm";
  folder.write("a.pgm", wide_pgm({0, 255, 256, 2047, 4095}, 65535));
  const auto black = read_gray_image(file);
  ASSERT_TRUE(black);
  EXPECT_EQ(black->pixels, (std::vector<std::uint8_t>{0, 0, 1, 7, 15}));
  EXPECT_EQ(bits_at_lower_end(*black), 12);
  EXPECT_NE(bits_advice(*black, "--bits").find("--bits 12"), std::string::npos);
  EXPECT_NE(bits_advice(*black, "camera.bits").find("camera.bits = 12"), std::string::npos);
  const auto right = read_gray_image(file, 12);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->pixels, (std::vector<std::uint8_t>{0, 15, 16, 127, 255}));
  EXPECT_EQ(bits_at_lower_end(*right), std::nullopt);
  EXPECT_EQ(read_gray_image(file, 10)->pixels, (std::vector<std::uint8_t>{0, 63, 64, 255, 255})) << "above the bits: 255";
  std::vector<std::uint8_t> pixels(5);
  ASSERT_TRUE(read_gray_image_into(file.string(), {pixels.data(), 5, 1, 5}, 12));
  EXPECT_EQ(pixels, right->pixels);
}

TEST(ImageFile, SamplesThatUseTheirRangeAreNotTakenForFewerBits) {
  const ScratchFolder folder;
  const auto bits_of = [&](const std::vector<int>& samples, int maximum) {
    folder.write("a.pgm", wide_pgm(samples, maximum));
    return bits_at_lower_end(*read_gray_image(folder.path() / "a.pgm"));
  };
  EXPECT_EQ(bits_of({1, 40000}, 65535), std::nullopt);
  EXPECT_EQ(bits_of({16, 3 * 256}, 65535), std::nullopt) << "12 bits at the upper end, a dark scene: its lowest bits are 0";
  EXPECT_EQ(bits_of({1, 4095}, 4095), std::nullopt) << "the maximum says it";
  EXPECT_EQ(bits_of({1, 1000}, 4095), 10);
  EXPECT_EQ(bits_of({1, 200}, 65535), 8);
  EXPECT_EQ(bits_of({1, 16000}, 65535), 14);
}

TEST(ImageFile, CutImagesOfOurOwnAreRefused) {
  const ScratchFolder folder;
  for (const char* name : {"a.png", "a.pgm"}) {
    const auto file = folder.path() / name;
    ASSERT_TRUE(write_gray_image(file, test_image(64, 48, 3).view()));
    ASSERT_TRUE(read_gray_image(file)) << name;
    const std::string whole = bytes_of(file);
    for (std::size_t bytes = 0; bytes < whole.size(); bytes += 1 + whole.size() / 200) {
      folder.write(name, whole.substr(0, bytes));
      EXPECT_FALSE(read_gray_image(file)) << name << " " << bytes;
    }
  }
}

TEST(ImageFile, StridesAreKept) {
  const ScratchFolder folder;
  const GrayImage image = test_image(40, 9, 1);
  const GrayView part{image.pixels.data() + 3, 20, 9, 40};
  for (const char* name : {"a.png", "a.pgm"}) {
    const auto file = folder.path() / name;
    ASSERT_TRUE(write_gray_image(file, part));
    std::vector<std::uint8_t> pixels(30 * 9, 99);
    ASSERT_TRUE(read_gray_image_into(file.string(), {pixels.data(), 20, 9, 30}));
    for (int v = 0; v < 9; ++v) {
      EXPECT_TRUE(std::equal(part.row(v), part.row(v) + 20, pixels.data() + 30 * v));
      EXPECT_EQ(pixels[static_cast<std::size_t>(30 * v + 20)], 99);
    }
    EXPECT_FALSE(read_gray_image_into(file.string(), {pixels.data(), 21, 9, 30}));
  }
}

TEST(Truth, ComesBackAsWritten) {
  const ScratchFolder folder;
  Truth truth{dsp::ModeList::standard(5).value(), {}};
  for (unsigned i = 0; i < 3; ++i) {
    TruthRow row{i + 2, 20'000'000 * i, dsp::Coefficients<double>(5)};
    for (int j = 0; j < 5; ++j) row.coefficients[j] = 80.0 / (j + 3.0 + i);
    truth.rows.push_back(row);
  }
  ASSERT_TRUE(write_truth(folder.path() / "truth.csv", truth));
  EXPECT_EQ(bytes_of(folder.path() / "truth.csv").substr(0, 29), "frame,time_ns,A00,B,C,A10,A01");
  const auto read = read_truth(folder.path() / "truth.csv");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->modes, truth.modes);
  ASSERT_EQ(read->rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read->rows[i].frame, truth.rows[i].frame);
    EXPECT_EQ(read->rows[i].coefficients, truth.rows[i].coefficients);
  }
  for (const char* bad : {"", "time,A00\n", "frame,time_ns,D\n", "frame,time_ns,A00,A00\n", "frame,time_ns,A00\n0,0\n",
                          "frame,time_ns,A00\n0,0,x\n", "frame,time_ns,A00\n0,0,nan\n"})
    EXPECT_FALSE(read_truth(folder.write("bad.csv", bad))) << bad;
}

}  // namespace
}  // namespace srd
