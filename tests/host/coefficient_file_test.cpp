// SPDX-License-Identifier: Apache-2.0
#include "host/listen/coefficient_file.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include <gtest/gtest.h>

#include "drivers/support/csv_table.hpp"
#include "host/coefficients/columns.hpp"
#include "host/coefficients/row_writer.hpp"
#include "host/listen/frames_in_file.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

// A folder that is gone afterwards.
struct Folder {
  Folder() {
    std::string name = (fs::temp_directory_path() / "srd_coefficient_file_XXXXXX").string();
    path = ::mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

const proto::BootId kNode{*proto::NodeId::make("cam-1"), 18446744073709551615u};

proto::CoefficientFrame frame_of(int parameters, float height) {
  proto::CoefficientFrame frame;
  frame.status = proto::FrameStatus::kOk;
  frame.stamp = {1700000000123456789, ClockId::kRealtime, 0, 0};
  frame.model.modes = dsp::ModeList::standard(parameters).value();
  frame.model.lx = 200;
  frame.model.ly = 400;
  frame.refractive_index = 1.333f;
  (void)frame.plates.push({12.7f, 1.49f});
  frame.centre_x_mm = 100;
  frame.centre_y_mm = 200;
  frame.pattern_x_mm = 180;
  frame.pattern_y_mm = 360;
  frame.coefficients.setZero(parameters);
  frame.coefficients[0] = height;
  if (parameters >= 3) frame.coefficients[1] = 2;  // B: X / Lx
  frame.information.size = parameters;
  for (int i = 0; i < parameters; ++i) {
    frame.information.scale[static_cast<std::size_t>(i)] = 100.0f / 25000;
    frame.information.entries[proto::InformationFactor::index(i, i)] = 25000;
  }
  frame.mean_error = 0.0625f;
  frame.corners_expected = 100;
  frame.corners_found = 90;
  frame.corners_used = 80;
  return frame;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::unique_ptr<CoefficientFile> open(const fs::path& file, OpenMode mode) {
  auto record = CoefficientFile::open(file, mode);
  EXPECT_TRUE(record.ok()) << (record.ok() ? "" : record.error().text());
  return record.ok() ? std::move(*record) : nullptr;
}

void write(CoefficientFile& record, std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  ASSERT_TRUE(record.write(kNode, sequence, frame).ok());
  ASSERT_TRUE(record.flush().ok());
}

TEST(CoefficientFile, WritesTheColumnsThatProgramsAgreeOn) {
  const Folder folder;
  const auto record = open(folder.path / "run.csv", OpenMode::kNew);
  proto::CoefficientFrame dated = frame_of(3, 80.25f);
  dated.stamp.wall_time_ns = 1790000000123456789;
  dated.stamp.wall_uncertainty_ns = 1234;
  dated.systematic.pose_day = 20000;
  dated.systematic.deviation.resize(3);
  dated.systematic.deviation << 0.5f, 0.25f, 0.125f;
  dated.systematic.height_mm = 0.0625f;
  write(*record, 7, dated);
  proto::CoefficientFrame none = frame_of(3, 0);
  none.coefficients.resize(0);
  none.information.size = 0;
  none.status = proto::FrameStatus::kLost;
  write(*record, 8, none);
  proto::CoefficientFrame unsure = frame_of(3, 80);
  unsure.information.size = 0;
  write(*record, 9, unsure);
  EXPECT_EQ(text_of(folder.path / "run.csv"),
            "node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm,A00,B,C,sd_A00,sd_B,"
            "sd_C,wall_time_ns,wall_uncertainty_ns,sys_A00,sys_B,sys_C,sys_height_mm\n"
            "cam-1,bffffffffffffffff,7,1700000000123456789,realtime,ok,100,90,80,0.0625,reprojection,81.25,80.25,2,0,0.01,0.01,"
            "0.01,1790000000123456789,1234,0.5,0.25,0.125,0.0625\n"
            "cam-1,bffffffffffffffff,8,1700000000123456789,realtime,lost,100,90,80,,reprojection,,,,,,,,,,,,,\n"
            "cam-1,bffffffffffffffff,9,1700000000123456789,realtime,ok,100,90,80,0.0625,reprojection,81,80,2,0,,,,,,,,,\n");
  const auto table = CsvTable::read(folder.path / "run.csv");
  ASSERT_TRUE(table.ok());
  EXPECT_TRUE(std::isnan(table->numbers("A00").value()[1]));
}

TEST(CoefficientFile, TheModelBesideItNamesTheSourcesOfTheSystematicDeviationsFromTheFirstRowOn) {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  const auto record = open(file, OpenMode::kNew);
  // The first record has no surface, and yet says whose errors its node counts.
  proto::CoefficientFrame none = frame_of(3, 0);
  none.coefficients.resize(0);
  none.information.size = 0;
  none.systematic.pose_day = *parse_day("2026-11-28");
  none.systematic.calibration_day = *parse_day("2026-11-27");
  write(*record, 0, none);
  const proto::BootId other{*proto::NodeId::make("cam-2"), 2};
  ASSERT_TRUE(record->write(other, 0, frame_of(3, 1)).ok());
  const auto models = read_model_file(model_file_path(file));
  ASSERT_TRUE(models.ok()) << models.error().text();
  ASSERT_TRUE(models->find("cam-1")->systematic);
  EXPECT_EQ(sources_text(*models->find("cam-1")->systematic), "the pose of 2026-11-28 and the calibration of 2026-11-27");
  EXPECT_FALSE(models->find("cam-2")->systematic);
}

TEST(CoefficientFile, CoefficientsComeBackToTheLastBit) {
  for (const float a : {1.0f / 3, 1e-7f, 123456.789f, -0.0f, std::nextafter(80.0f, 81.0f)}) {
    proto::CoefficientFrame frame = frame_of(1, a);
    std::string row = coefficient_header(frame.model.modes);
    append_row(row_content(kNode, 0, frame), row);
    const auto back = CsvTable::parse(row, "row").value().numbers("A00").value();
    EXPECT_EQ(static_cast<float>(back[0]), a);
  }
}

TEST(CoefficientFile, ADoubleKeepsNineDigitsAndWhatIsNotFiniteGivesAnEmptyCell) {
  RowContent row;
  row.node = "reconstruct";
  row.metric = kPatternMetric;
  row.status = proto::FrameStatus::kOk;
  row.modes = 3;
  row.mean_error = 0.5;
  row.height_mm = 80.123456789;
  row.coefficients = dsp::Coefficients<double>(3);
  row.coefficients << 80.1234567891, -1.0 / 3, 2e-7;
  row.deviations = dsp::Coefficients<double>(3);
  row.deviations << 0.0123456, std::nan(""), std::numeric_limits<double>::infinity();
  std::string text;
  append_row(row, text);
  EXPECT_EQ(text,
            "reconstruct,b0000000000000000,0,0,unknown,ok,0,0,0,0.5,pattern,80.1234568,80.1234568,-0.333333333,2e-07,0.01235,,,"
            ",,,,,\n");
  EXPECT_STREQ(error_unit(kPatternMetric), "grey levels");
  EXPECT_STREQ(error_unit("disparity"), "mm");
  EXPECT_STREQ(error_unit("weather"), "");
}

TEST(CoefficientFile, RefusesAnExistingFileUnlessForced) {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  std::ofstream(file) << "precious\n";
  const auto refused = CoefficientFile::open(file, OpenMode::kNew);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().exit, Exit::kUsage);
  EXPECT_EQ(refused.error().where, file.string());
  EXPECT_EQ(text_of(file), "precious\n");
  EXPECT_FALSE(CoefficientFile::open(file, OpenMode::kAppend).ok());  // not ours
  EXPECT_EQ(text_of(file), "precious\n");
  write(*open(file, OpenMode::kReplace), 0, frame_of(1, 1));
  EXPECT_TRUE(text_of(file).starts_with("node,boot,"));
  EXPECT_FALSE(CoefficientFile::open(folder.path / "no" / "such" / "folder.csv", OpenMode::kNew).ok());
}

TEST(CoefficientFile, AppendingKnowsWhatIsThere) {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  {
    const auto record = open(file, OpenMode::kAppend);  // starts one that is not there
    for (const std::uint64_t s : {5, 6, 7, 9}) write(*record, s, frame_of(3, 1));
  }
  const std::string before = text_of(file);
  const auto record = open(file, OpenMode::kAppend);
  ASSERT_EQ(record->frames_in_file().size(), 1u);
  EXPECT_EQ(record->frames_in_file().at(kNode).ranges(), (std::vector<proto::SequenceRange>{{5, 8}, {9, 10}}));
  write(*record, 10, frame_of(3, 2));
  EXPECT_TRUE(text_of(file).starts_with(before));
  EXPECT_EQ(CsvTable::read(file).value().rows(), 5u);
}

TEST(CoefficientFile, CutAtAnyByteIsContinuedFromTheLastWholeRow) {
  const Folder folder;
  const fs::path whole = folder.path / "whole.csv";
  {
    const auto record = open(whole, OpenMode::kNew);
    for (std::uint64_t s = 0; s < 3; ++s) write(*record, s, frame_of(1, 80.5f));
  }
  const std::string text = text_of(whole);
  const std::size_t header = text.find('\n') + 1;
  const std::size_t row = (text.size() - header) / 3;
  for (std::size_t bytes = 0; bytes <= text.size(); ++bytes) {
    const fs::path file = folder.path / "cut.csv";
    std::ofstream(file, std::ios::binary) << text.substr(0, bytes);
    const std::uint64_t rows = bytes < header ? 0 : (bytes - header) / row;
    const auto record = open(file, OpenMode::kAppend);
    ASSERT_TRUE(record) << bytes;
    ASSERT_EQ(record->frames_in_file().size(), rows > 0 ? 1u : 0u) << bytes;
    if (rows > 0) {
      ASSERT_EQ(record->frames_in_file().at(kNode).end(), rows);
    }
    for (std::uint64_t s = rows; s < 3; ++s) ASSERT_TRUE(record->write(kNode, s, frame_of(1, 80.5f)).ok());
    ASSERT_TRUE(record->flush().ok());
    ASSERT_EQ(text_of(file), text) << bytes;
  }
}

TEST(CoefficientFile, EachListOfModesHasItsFile) {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  const proto::BootId other{*proto::NodeId::make("cam-2"), 2};
  {
    const auto record = open(file, OpenMode::kNew);
    write(*record, 0, frame_of(5, 1));
    ASSERT_TRUE(record->write(other, 0, frame_of(3, 1)).ok());
    ASSERT_TRUE(record->flush().ok());
    EXPECT_EQ(record->files().size(), 2u);
  }
  EXPECT_EQ(CsvTable::read(file).value().words("node").value(), std::vector<std::string>{"cam-1"});
  EXPECT_EQ(CsvTable::read(folder.path / "run.A00-B-C.csv").value().words("node").value(), std::vector<std::string>{"cam-2"});
  // The file beside it is as much the record as the first.
  const auto record = open(file, OpenMode::kAppend);
  EXPECT_TRUE(record->frames_in_file().contains(other));
  ASSERT_TRUE(record->write(other, 1, frame_of(3, 1)).ok());
  ASSERT_TRUE(record->flush().ok());
  EXPECT_EQ(CsvTable::read(folder.path / "run.A00-B-C.csv").value().rows(), 2u);
  fs::remove(file);
  EXPECT_FALSE(CoefficientFile::open(file, OpenMode::kNew).ok());
}

TEST(CoefficientFile, SaysWhichModelTheRowsBelongTo) {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  const proto::BootId other{*proto::NodeId::make("cam-2"), 2};
  {
    const auto record = open(file, OpenMode::kNew);
    write(*record, 0, frame_of(3, 1));
    ASSERT_TRUE(record->write(other, 0, frame_of(3, 1)).ok());
    EXPECT_TRUE(record->notes().empty());
  }
  auto model_file = read_model_file(model_file_path(file));
  ASSERT_TRUE(model_file.ok()) << model_file.error().text();
  ASSERT_EQ(model_file->nodes.size(), 2u);
  const NodeModel* model = model_file->find("cam-1");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->model.lx, 200);
  EXPECT_EQ(model->model.ly, 400);
  EXPECT_EQ(model->refractive_index, 1.333);
  EXPECT_TRUE(same_plates(model->plates, {{12.7, 1.49}})) << plates_text(model->plates);
  EXPECT_EQ(model->pattern, (PatternExtent{10, 190, 20, 380}));
  // The same again says nothing; another model is noted.
  const auto record = open(file, OpenMode::kAppend);
  write(*record, 1, frame_of(3, 1));
  EXPECT_TRUE(record->notes().empty());
  proto::CoefficientFrame changed = frame_of(3, 1);
  changed.model.lx = 250;
  ASSERT_TRUE(record->write({kNode.node, 99}, 0, changed).ok());
  EXPECT_EQ(record->notes().size(), 1u);
  model_file = read_model_file(model_file_path(file));
  EXPECT_EQ(model_file->find("cam-1")->model.lx, 250);
  EXPECT_EQ(model_file->nodes.size(), 2u);
}

// A node of an earlier version may have such a name.
TEST(CoefficientFile, SaysOnceThatANodesNameReadsAsAValueAndKeepsItsFrames) {
  const Folder folder;
  const auto record = open(folder.path / "run.csv", OpenMode::kNew);
  const proto::BootId odd{*proto::NodeId::make("NA"), 2};
  for (std::uint64_t s = 0; s < 2; ++s) ASSERT_TRUE(record->write(odd, s, frame_of(1, 80)).ok());
  ASSERT_TRUE(record->flush().ok());
  ASSERT_EQ(record->notes().size(), 1u);
  EXPECT_NE(record->notes()[0].find("node 'NA'"), std::string::npos);
  EXPECT_EQ(CsvTable::read(folder.path / "run.csv").value().words("node").value(), (std::vector<std::string>{"NA", "NA"}));
}

TEST(CoefficientFile, ForeignRowsAreAnErrorWithTheirLine) {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  std::ofstream(file) << coefficient_header(dsp::ModeList::standard(1).value()) << "cam,b0000000000000001,x,0\n";
  const auto bad = read_frames_in_file(file);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().where, file.string() + ":2");
  for (const char* boot : {"1", "b1", "b00000000000000FF", "bffffffffffffffffff", "NA"}) {
    std::ofstream(file) << coefficient_header(dsp::ModeList::standard(1).value()) << "cam," << boot << ",3,0\n";
    EXPECT_FALSE(read_frames_in_file(file).ok()) << boot;
  }
}

TEST(CsvRow, HeaderNamesItsModes) {
  for (const int n : {1, 3, 5, 8, 12}) {
    const auto modes = dsp::ModeList::standard(n).value();
    std::string header = coefficient_header(modes);
    header.pop_back();
    const auto back = modes_of_header(header);
    ASSERT_TRUE(back.has_value());
    EXPECT_TRUE(*back == modes);
  }
  EXPECT_EQ(boot_text(0), "b0000000000000000");
  EXPECT_EQ(boot_text(0x12'3456'789a'bcde), "b00123456789abcde");
  EXPECT_FALSE(modes_of_header("node,boot").has_value());
  EXPECT_FALSE(modes_of_header("").has_value());
}

}  // namespace
}  // namespace srd::host
