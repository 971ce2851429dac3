// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/model_file.hpp"

#include <gtest/gtest.h>

#include "tests/fakes/scratch_folder.hpp"

namespace srd::host {
namespace {

NodeModel flume(const std::string& name) {
  NodeModel node;
  node.node = name;
  node.model = {*dsp::ModeList::standard(5), 400, 800.125, -3, 1.0 / 3};
  node.refractive_index = 1.33302;
  node.pattern = PatternExtent{0, 200, -10, 400};
  return node;
}

const std::string kGood = model_file_text({{flume("a")}});

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(ModelFile, ReadsBackWhatItWrote) {
  ModelFile written{{flume("flume-1"), flume("odd \"name\"\\\t")}};
  written.nodes[1].pattern.reset();
  written.nodes[1].plates = {{12, 1.49}, {1.0 / 3, 1}};
  written.nodes[0].systematic = ErrorSources{*parse_day("2026-11-28"), 0};
  written.nodes[1].systematic = ErrorSources{0, std::nullopt};
  const fakes::ScratchFolder scratch;
  const auto file = model_file_path(scratch.path() / "model_file.csv");
  EXPECT_EQ("model_file.csv.model.toml", file.filename());
  ASSERT_TRUE(write_model_file(file, written));
  const auto read = read_model_file(file);
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(2u, read->nodes.size());
  for (std::size_t i = 0; i < 2; ++i) {
    const NodeModel &a = written.nodes[i], &b = read->nodes[i];
    EXPECT_EQ(a.node, b.node);
    EXPECT_TRUE(a.model.modes == b.model.modes);
    EXPECT_EQ(a.model.lx, b.model.lx);
    EXPECT_EQ(a.model.ly, b.model.ly);
    EXPECT_EQ(a.model.x0, b.model.x0);
    EXPECT_EQ(a.model.y0, b.model.y0);
    EXPECT_EQ(a.refractive_index, b.refractive_index);
    EXPECT_EQ(a.pattern, b.pattern);
    EXPECT_TRUE(same_plates(a.plates, b.plates)) << plates_text(b.plates);
    EXPECT_EQ(a.systematic, b.systematic);
  }
  EXPECT_EQ(&read->nodes[0], read->find("flume-1"));
  EXPECT_EQ(nullptr, read->find("flume"));
}

TEST(ModelFile, NamesWhatIsWrongAndWhere) {
  struct Case {
    std::string text, says, line;
  };
  const Case cases[] = {
      {"", "'node' is missing", "m.toml"},
      {replaced(kGood, "lx = 400.0\n", ""), "lx' is missing", "m.toml:3"},
      {replaced(kGood, "lx = 400.0", "lx = -1"), "lx'", "m.toml:6"},
      {replaced(kGood, "lx = 400.0", "lx = \"400\""), "lx'", "m.toml:6"},
      {replaced(kGood, "\"B\"", "\"D\""), "D", "m.toml:5"},
      {replaced(kGood, "\"B\"", "\"C\""), "different modes", "m.toml:5"},
      {replaced(kGood, "refractive_index", "refractiv_index"), "unknown key", "m.toml:10"},
      {replaced(kGood, "pattern_x = [0.0, 200.0]\n", ""), "pattern_x' is missing", "m.toml:3"},
      {replaced(kGood, "[0.0, 200.0]", "[200.0, 0.0]"), "pattern_x'", "m.toml:11"},
      {kGood + kGood.substr(kGood.find("[[node]]")), "every node once", "m.toml:14"},
  };
  for (const Case& c : cases) {
    const auto read = parse_model_file(c.text, "m.toml");
    ASSERT_FALSE(read) << c.text;
    EXPECT_EQ(Exit::kUsage, read.error().exit);
    EXPECT_NE(std::string::npos, read.error().text().find(c.says)) << c.says << "\n" << read.error().text();
    EXPECT_NE(std::string::npos, read.error().text().find(c.line + ": ")) << c.line << "\n" << read.error().text();
  }
}

}  // namespace
}  // namespace srd::host
