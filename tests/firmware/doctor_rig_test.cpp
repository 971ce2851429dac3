// SPDX-License-Identifier: Apache-2.0
// The doctor at rigs that stand as their pose says, and at others.
#include <gtest/gtest.h>

#include "firmware/doctor/doctor.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

constexpr const char* kStill =
    "[[surface.mode]]\nname = \"A00\"\nmean_mm = 87.0\n[[surface.mode]]\nname = \"B\"\n[[surface.mode]]\nname = \"C\"\n";

// What is said of a rig whose camera has turned by so many degrees about its x axis since the pose was found.
Finding rig_finding(const std::string& scene_text, double turned_deg, const std::string& water = "") {
  const fakes::ScratchFolder folder;
  folder.write("scene.toml", "[camera]\nrate_hz = 5.0\n" + scene_text);
  dsp::PoseChange turn = dsp::PoseChange::Zero();
  turn[0] = turned_deg * M_PI / 180;
  PoseErrors errors;  // of a pose from one reference image
  errors.covariance.diagonal() << 1e-10, 1e-10, 1e-10, 1e-4, 1e-4, 1e-4;
  EXPECT_TRUE(write_pose(folder.path() / "pose.yml", dsp::changed(default_scene().pose, turn), errors).ok());
  auto config = NodeConfig::parse("[camera]\nsource = \"simulator\"\nrate = \"max\"\nscene = \"" +
                                      (folder.path() / "scene.toml").string() + "\"\n[geometry]\npose = \"" +
                                      (folder.path() / "pose.yml").string() +
                                      "\"\n[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n" + water,
                                  "node.toml");
  EXPECT_TRUE(config.ok()) << config.error().text();
  auto instrument = make_instrument(*config);
  EXPECT_TRUE(instrument.ok()) << instrument.error().text();
  DoctorOptions options;
  options.camera_time = std::chrono::milliseconds(600);
  Diagnosis diagnosis;
  check_camera(
      *config, *instrument, [](const Camera&) -> Outcome<std::unique_ptr<Strobe>> { return std::unique_ptr<Strobe>(); },
      options, diagnosis);
  for (const Finding& finding : diagnosis.findings())
    if (finding.subject == "rig") return finding;
  ADD_FAILURE() << "nothing is said of the rig";
  return {};
}

TEST(DoctorRig, StandsAsItsPoseSaysThroughStillWaterOfAnyLevel) {
  const Finding finding = rig_finding(kStill, 0);
  EXPECT_EQ(finding.verdict, Verdict::kOk) << finding.text();
  EXPECT_NE(finding.found.find("as the pose says"), std::string::npos) << finding.text();
  EXPECT_NE(finding.found.find("still water of 8"), std::string::npos) << finding.text();
}

TEST(DoctorRig, HasMovedByASmallTurnUnderStillWater) {
  const Finding finding = rig_finding(kStill, 0.05);
  EXPECT_EQ(finding.verdict, Verdict::kWarn) << finding.text();
  EXPECT_NE(finding.found.find("has moved since the pose was found"), std::string::npos) << finding.text();
  EXPECT_NE(finding.advice.find("srd pose"), std::string::npos) << finding.text();
}

// Of water with air's index light knows nothing.
TEST(DoctorRig, IsJudgedDryToo) {
  const std::string dry = std::string("[tank]\nrefractive_index = 1.0\n") + kStill;
  const Finding unmoved = rig_finding(dry, 0, "[water]\nrefractive_index = 1.333\n");
  EXPECT_EQ(unmoved.verdict, Verdict::kOk) << unmoved.text();
  EXPECT_NE(unmoved.found.find("seen dry"), std::string::npos) << unmoved.text();
  const Finding moved = rig_finding(dry, 0.02, "[water]\nrefractive_index = 1.333\n");
  EXPECT_EQ(moved.verdict, Verdict::kWarn) << moved.text();
  EXPECT_NE(moved.found.find("has moved"), std::string::npos) << moved.text();
}

TEST(DoctorRig, IsNotComparedThroughWavesAndThatIsTold) {
  const Finding finding = rig_finding("", 0);  // modes of 3 mm
  EXPECT_EQ(finding.verdict, Verdict::kWarn) << finding.text();
  EXPECT_NE(finding.found.find("not compared with the pose"), std::string::npos) << finding.text();
  EXPECT_NE(finding.advice.find("still water"), std::string::npos) << finding.text();
}

// A tilt of the water that comes and goes looks in one frame as a turn of the camera does.
TEST(DoctorRig, HasNotMovedUnderSmallWavesWhateverTheirPhase) {
  for (const char* phase : {"80.0", "170.0"}) {
    std::string scene = "[[surface.mode]]\nname = \"A00\"\nmean_mm = 80.0\n";
    for (const char* mode : {"B", "C"})
      scene += std::string("[[surface.mode]]\nname = \"") + mode +
               "\"\namplitude_mm = 0.3\nfrequency_hz = 0.7\nphase_deg = " + phase + "\n";
    const Finding finding = rig_finding(scene, 0);
    EXPECT_EQ(finding.found.find("has moved"), std::string::npos) << phase << ": " << finding.text();
  }
}

}  // namespace
}  // namespace srd::firmware
