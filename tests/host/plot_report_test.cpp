// SPDX-License-Identifier: Apache-2.0
// The files of `srd plot`.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "drivers/support/text_file.hpp"
#include "host/plot/command.hpp"
#include "host/plot/figures.hpp"
#include "host/plot/report.hpp"
#include "tests/fakes/command_run.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/host/csv_header.hpp"

// fontconfig, under cairo's text, keeps what it read until the process ends: no leak of ours.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }

namespace srd::host {
namespace {

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class PlotReport : public testing::Test {
 protected:
  // 100 frames at 50 Hz: 20 to 29 lost, 50 to 59 never received.
  std::string frames(const std::string& node = "flume-1") const {
    std::string text = kThreeModesHeader;
    for (int i = 0; i < 100; ++i) {
      if (i >= 50 && i < 60) continue;
      const double a = 80 + std::sin(0.3 * i);
      text += node + ",1," + std::to_string(i) + "," + std::to_string(1000 + 20'000'000LL * i) + ",monotonic,";
      text += i >= 20 && i < 30
                  ? "lost,9,0,0,,,,,,,,,\n"
                  : "tracking,9,9,9,0.01,reprojection," + number_text(a) + "," + number_text(a) + ",1,2,0.1,0.1,0.1\n";
    }
    return text;
  }
  std::filesystem::path truth() const {
    std::string text = "frame,time_ns,A00,B,C\n";
    for (int i = 0; i < 100; ++i)
      text += std::to_string(i) + "," + std::to_string(1000 + 20'000'000LL * i) + "," + number_text(80.01 + std::sin(0.3 * i)) +
              ",1,2\n";
    return folder_.write("truth.csv", text);
  }
  PlotOptions options(const std::string& text) const {
    PlotOptions o;
    o.file = folder_.write("run.csv", text);
    o.out = folder_.path() / "out";
    return o;
  }
  PlotOptions full() const {
    PlotOptions o = options(frames());
    o.truth = truth();
    o.geometry.points = folder_.write("points.txt", "0 0 0\n100 0 0\n0 200 0\n100 200 0\n");
    o.geometry.lx = 100;
    o.geometry.ly = 200;
    return o;
  }
  void expect_problem(const std::string& text, const std::string& where, const std::string& says) const {
    const auto files = plot(options(text));
    ASSERT_FALSE(files);
    EXPECT_EQ(Exit::kInput, files.error().exit);
    EXPECT_EQ((folder_.path() / "run.csv").string() + where, files.error().where) << files.error().text();
    EXPECT_NE(std::string::npos, files.error().text().find(says)) << files.error().text();
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out"));
  }

  fakes::ScratchFolder folder_;
};

TEST_F(PlotReport, WritesEveryFigureAndAPageThatNeedsNothingElse) {
  const auto files = plot(full());
  ASSERT_TRUE(files) << files.error().text();
  ASSERT_EQ(5u, files->written.size());
  EXPECT_TRUE(files->notes.empty());
  for (std::size_t i = 1; i < 5; ++i) EXPECT_EQ("\x89PNG", contents(files->written[i]).substr(0, 4));
  std::string page = contents(files->written[0]);
  ASSERT_EQ("run.html", files->written[0].filename());
  std::size_t svgs = 0;
  for (std::size_t at = 0; (at = page.find("<svg xmlns", at)) != std::string::npos; ++at) ++svgs;
  EXPECT_EQ(4u, svgs);
  EXPECT_NE(std::string::npos, page.find("<td>A00</td><td>0.0100</td>"));  // the error that was put in
  // The name of the SVG language is no address that anything is read from.
  const std::string name = "http://www.w3.org/2000/svg";
  for (std::size_t at; (at = page.find(name)) != std::string::npos;) page.erase(at, name.size());
  for (const char* outside : {"http:", "https:", "src=", "<link", "url(", "@import", "fetch(", "href=\"/", "file:"})
    EXPECT_EQ(std::string::npos, page.find(outside)) << outside;
}

TEST_F(PlotReport, NamesWhatTheLightWentThrough) {
  PlotOptions o = options(frames());
  (void)folder_.write(
      "run.csv.model.toml",
      model_file_text(
          {{{"flume-1", {*dsp::ModeList::standard(3), 100, 200, 0, 0}, 1.34, PatternExtent{0, 100, 0, 200}, {{12, 1.49}}}}}));
  const auto files = plot(o);
  ASSERT_TRUE(files) << files.error().text();
  const std::string page = contents(files->written[0]);
  EXPECT_NE(std::string::npos, page.find("1.34000, floor plates 12 mm of index 1.49")) << page.substr(0, 2000);
}

// Two lines a mode beside the estimate, and beside the height; none where the file says nothing.
TEST_F(PlotReport, ShowsSystematicDeviationsApartFromRandomOnes) {
  std::string text = frames(), with;
  std::size_t line = 0;
  for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1, ++line) {
    const std::string row = text.substr(at, end - at);
    with += row +
            (line == 0                               ? ",sys_A00,sys_B,sys_C,sys_height_mm"
             : row.find("lost") != std::string::npos ? ",,,,"
                                                     : ",0.2,0.3,0.4,0.5") +
            "\n";
  }
  const auto lines_of = [](const Figure& figure, const std::string& role) {
    return std::count_if(figure.scene.shapes().begin(), figure.scene.shapes().end(), [&](const Shape& shape) {
      const auto* lines = std::get_if<Lines>(&shape);
      return lines != nullptr && lines->role == role;
    });
  };
  for (const bool known : {true, false}) {
    const auto run = read_coefficient_run(options(known ? with : frames()).file, "");
    ASSERT_TRUE(run) << run.error().text();
    const PlotInput input{*run, make_timeline(*run), {}, {}, {}};
    EXPECT_EQ(known ? 6 : 0, lines_of(coefficient_figure(input), "systematic"));
    EXPECT_EQ(known ? 2 : 0, lines_of(*height_figure(input), "systematic"));
  }
  const auto files = plot(options(with));
  ASSERT_TRUE(files) << files.error().text();
  EXPECT_NE(std::string::npos, contents(files->written[0]).find("Systematic deviation of heights</dt><dd>0.5 mm"))
      << contents(files->written[0]).substr(0, 3000);
}

TEST_F(PlotReport, LinesStopAtGaps) {
  const auto run = read_coefficient_run(options(frames()).file, "");
  ASSERT_TRUE(run);
  PlotInput input{*run, make_timeline(*run), {}, {}, {}};
  const Figure figure = coefficient_figure(input);
  std::size_t series = 0;
  for (const Shape& shape : figure.scene.shapes()) {
    const auto* lines = std::get_if<Lines>(&shape);
    if (lines == nullptr || lines->role != "series") continue;
    ++series;
    // 0-19, 30-49, 60-99
    ASSERT_EQ(3u, lines->parts.size());
    EXPECT_EQ(20u, lines->parts[0].size());
    EXPECT_EQ(20u, lines->parts[1].size());
    EXPECT_EQ(40u, lines->parts[2].size());
  }
  EXPECT_EQ(3u, series);
}

TEST_F(PlotReport, ReplacesNothingWithoutForce) {
  PlotOptions o = full();
  const auto there = folder_.write("out/run-surface.png", "mine");
  const auto refused = plot(o);
  ASSERT_FALSE(refused);
  EXPECT_EQ(Exit::kUsage, refused.error().exit);
  EXPECT_EQ(there.string(), refused.error().where);
  EXPECT_EQ("mine", contents(there));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out/run.html"));
  o.force = true;
  ASSERT_TRUE(plot(o));
  EXPECT_NE("mine", contents(there));
}

TEST_F(PlotReport, WithoutAModelItSaysWhatIsLeftOut) {
  const auto files = plot(options(frames()));
  ASSERT_TRUE(files);
  EXPECT_EQ(3u, files->written.size());
  ASSERT_EQ(1u, files->notes.size());
  EXPECT_NE(std::string::npos, files->notes[0].find("--lx"));
}

TEST_F(PlotReport, WrongFilesAreNamedByFileAndLine) {
  expect_problem("", "", "no header");
  expect_problem(kThreeModesHeader, ":1", "no frames");
  std::string text = frames();
  expect_problem(text.replace(text.find("sd_B"), 4, "sd_X"), ":1", "sd_X");
  text = frames();
  expect_problem(text.replace(text.find("status"), 6, "state"), ":1", "no column 'status'");
  text = frames();
  expect_problem(text.replace(text.find("0.01,reprojection"), 4, "good"), ":2", "'good'");
  expect_problem(kThreeModesHeader + "n,1,0,1000,monotonic,lost,9,0,0,,,,,,,,,\nn,1,1,2000,monotonic,lost,9,0,0,,,,,,,,,\n",
                 ":2", "2 frames: 2 lost");
}

TEST_F(PlotReport, FrameMustHaveASurface) {
  PlotOptions o = full();
  o.frame = 25;
  EXPECT_NE(std::string::npos, plot(o).error().what.find("25 has no surface"));
  o.frame = 55;
  EXPECT_NE(std::string::npos, plot(o).error().what.find("no such frame"));
  o.frame = 61;
  const auto files = plot(o);
  ASSERT_TRUE(files);
  EXPECT_NE(std::string::npos, contents(files->written[0]).find("sequence 61,"));
}

TEST_F(PlotReport, NamesInThePageAreText) {
  const auto files = plot(options(frames("<script>&'")));
  ASSERT_TRUE(files);
  const std::string page = contents(files->written[0]);
  EXPECT_EQ(std::string::npos, page.find("<script>&'"));
  EXPECT_NE(std::string::npos, page.find("node &lt;script&gt;&amp;&#39;"));
}

TEST_F(PlotReport, CommandPrintsTheFilesAndItsCodes) {
  const auto run = [](std::vector<std::string> words) { return fakes::run_command(add_plot_command, std::move(words)); };
  const std::string file = folder_.write("run.csv", frames()).string(), out = (folder_.path() / "o").string();
  const auto first = run({"plot", file, "--out", out});
  EXPECT_EQ(0, first.exit);
  EXPECT_EQ(out + "/run.html\n" + out + "/run-series.png\n" + out + "/run-height.png\n", first.out);
  EXPECT_EQ(2, run({"plot", file, "--out", out}).exit);
  EXPECT_EQ(0, run({"plot", file, "--out", out, "--force"}).exit);
  EXPECT_EQ(2, run({"plot", file, "--out", out, "--force", "--lx", "100"}).exit);
  EXPECT_EQ(3, run({"plot", (folder_.path() / "none.csv").string()}).exit);
}

}  // namespace
}  // namespace srd::host
