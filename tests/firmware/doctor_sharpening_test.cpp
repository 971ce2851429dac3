// SPDX-License-Identifier: Apache-2.0
// The doctor at cameras that sharpen by a known unsharp mask.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "firmware/doctor/doctor.hpp"
#include "firmware/doctor/sharpening_check.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

// The finding on sharpening; subject empty: there is none.
Finding sharpening_of(const std::string& image) {
  const fakes::ScratchFolder folder;
  folder.write("scene.toml", "[image]\nblur_px = 0.5\nnoise = 1.0\n" + image);
  auto config = NodeConfig::parse("[camera]\nsource = \"simulator\"\nrate = \"max\"\nscene = \"" +
                                      (folder.path() / "scene.toml").string() +
                                      "\"\n[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n",
                                  "node.toml");
  EXPECT_TRUE(config.ok()) << config.error().text();
  auto instrument = make_instrument(*config);
  EXPECT_TRUE(instrument.ok()) << instrument.error().text();
  DoctorOptions options;
  options.camera_time = std::chrono::milliseconds(300);
  Diagnosis diagnosis;
  check_camera(
      *config, *instrument, [](const Camera&) -> Outcome<std::unique_ptr<Strobe>> { return std::unique_ptr<Strobe>(); },
      options, diagnosis);
  for (const Finding& finding : diagnosis.findings())
    if (finding.subject == "sharpening") return finding;
  return {};
}

TEST(DoctorSharpening, MeasuresTheUnsharpMaskAndNamesTheControl) {
  const Finding finding = sharpening_of("sharpen_amount = 1.0\nsharpen_radius_px = 1.2\n");
  EXPECT_EQ(finding.verdict, Verdict::kWarn) << finding.text();
  double amount = 0, radius = 0, blur = 0, percent = 0;
  ASSERT_EQ(
      std::sscanf(finding.found.c_str(), "unsharp mask of amount %lf, radius %lf px: edges of %lf px blur overshoot by %lf",
                  &amount, &radius, &blur, &percent),
      4)
      << finding.text();
  std::printf("  %s\n", finding.found.c_str());
  EXPECT_NEAR(amount, 1.0, 0.15);
  EXPECT_NEAR(radius, 1.2, 0.15);
  EXPECT_NEAR(blur, 0.5, 0.1);
  EXPECT_NEAR(percent, 100 * overshoot({4096, 4915}, 0.5), 3);
  EXPECT_NE(finding.advice.find("sharpen_amount"), std::string::npos) << finding.text();
}

TEST(DoctorSharpening, FindsNoneWhereThereIsNone) {
  const Finding finding = sharpening_of("");
  EXPECT_EQ(finding.verdict, Verdict::kOk) << finding.text();
  EXPECT_NE(finding.found.find("do not overshoot"), std::string::npos) << finding.text();
}

// Of a wide mask on an edge that is sharp against the pixel, a half remains: 1 + a / 2 at the edge.
TEST(DoctorSharpening, OvershootIsThatOfTheClosedForm) {
  EXPECT_EQ(overshoot({0, 4096}, 0.5), 0);
  const double limit = 1 - 0.5 * std::erfc(-0.5 / (4 * std::sqrt(2.0)));
  EXPECT_LT(overshoot({4096, 4 * 4096}, 0.05), limit);
  EXPECT_GT(overshoot({4096, 4 * 4096}, 0.05), limit - 0.02) << "a blur of 0.05 px moves the highest pixel by a tenth";
  EXPECT_LT(overshoot({4096, 4096}, 3.0), overshoot({4096, 4096}, 0.5)) << "a soft edge has little for the mask to lift";
}

}  // namespace
}  // namespace srd::firmware
