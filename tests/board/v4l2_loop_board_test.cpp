// SPDX-License-Identifier: Apache-2.0
// The frame loop over a live V4L2 camera: rendered water goes out of vivid's HDMI output, into its HDMI input, and through
// the driver to surfaces. Nothing comes from the heap, and nothing is paged in, once it runs.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "drivers/camera/v4l2/v4l2_apply.hpp"
#include "drivers/recording/image_file.hpp"
#include "drivers/support/mapped_region.hpp"
#include "drivers/support/unique_fd.hpp"
#include "firmware/config/instrument.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "firmware/realtime/realtime.hpp"
#include "tests/board/vivid.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/fakes/test_data.hpp"

namespace srd::board {
namespace {

constexpr int kWidth = 640, kHeight = 480;  // the least HDMI mode; the rendered frames fill its upper part
constexpr std::uint32_t kImages = 12;

// Where the flume's frames are: on a board the tests run without the source tree.
std::string data_folder() {
  const char* given = std::getenv("SRD_BOARD_DATA");
  return (given != nullptr ? std::string(given) : fakes::test_data().string()) + "/flume-small";
}

v4l2_dv_timings timings_640x480() {
  v4l2_dv_timings timings;
  std::memset(&timings, 0, sizeof timings);
  timings.type = V4L2_DV_BT_656_1120;
  timings.bt.width = kWidth;
  timings.bt.height = kHeight;
  timings.bt.pixelclock = 25'175'000;
  timings.bt.hfrontporch = 16;
  timings.bt.hsync = 96;
  timings.bt.hbackporch = 48;
  timings.bt.vfrontporch = 10;
  timings.bt.vsync = 2;
  timings.bt.vbackporch = 33;
  timings.bt.standards = V4L2_DV_BT_STD_CEA861 | V4L2_DV_BT_STD_DMT;
  return timings;
}

// Page faults so far of a thread, both kinds; without the heap.
long faults_of(pid_t thread) {
  char path[64], text[1024];
  std::snprintf(path, sizeof path, "/proc/self/task/%d/stat", thread);
  const UniqueFd file(::open(path, O_RDONLY | O_CLOEXEC));
  const ssize_t length = ::read(file.get(), text, sizeof text - 1);
  if (length <= 0) return -1;
  text[length] = '\0';
  const char* after_name = std::strrchr(text, ')');
  long minor = 0, major = 0;
  if (after_name == nullptr || std::sscanf(after_name + 1, " %*c %*d %*d %*d %*d %*d %*u %ld %*u %ld", &minor, &major) != 2)
    return -1;
  return minor + major;
}

pid_t this_thread() { return static_cast<pid_t>(::syscall(SYS_gettid)); }

// Plays the flume's frames forwards and backwards into vivid's output until it is told to end.
class Player {
 public:
  static std::unique_ptr<Player> start(Vivid& output, const std::string& folder) {
    std::vector<std::vector<std::uint8_t>> frames;
    for (std::uint32_t i = 0; i < kImages; ++i) {
      char name[32];
      std::snprintf(name, sizeof name, "/frame_%06u.png", i);
      const auto image = read_gray_image(folder + name);
      if (!image) return nullptr;
      std::vector<std::uint8_t> frame(static_cast<std::size_t>(kWidth * kHeight), 90);
      for (int v = 0; v < image->height; ++v)
        std::memcpy(&frame[static_cast<std::size_t>(v * kWidth)], image->view().row(v), static_cast<std::size_t>(image->width));
      frames.push_back(std::move(frame));
    }
    return std::unique_ptr<Player>(new Player(output.path(), std::move(frames)));
  }
  ~Player() {
    ending_ = true;
    thread_.join();
  }

 private:
  static constexpr std::uint32_t kBuffers = 4;
  Player(const std::string& path, std::vector<std::vector<std::uint8_t>> frames)
      : frames_(std::move(frames)), file_(::open(path.c_str(), O_RDWR | O_CLOEXEC)), thread_([this] { play(); }) {}

  static v4l2_buffer buffer(std::uint32_t index) {
    v4l2_buffer made;
    std::memset(&made, 0, sizeof made);
    made.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    made.memory = V4L2_MEMORY_MMAP;
    made.field = V4L2_FIELD_NONE;
    made.index = index;
    return made;
  }
  bool call(unsigned long request, void* argument) {
    if (::ioctl(file_.get(), request, argument) == 0) return true;
    std::perror("vivid's output");
    return false;
  }
  void play() {
    v4l2_requestbuffers wanted;
    std::memset(&wanted, 0, sizeof wanted);
    wanted.count = kBuffers;
    wanted.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    wanted.memory = V4L2_MEMORY_MMAP;
    if (!call(VIDIOC_REQBUFS, &wanted) || wanted.count != kBuffers) return;
    std::array<MappedRegion, kBuffers> memory;
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    for (std::uint32_t n = 0; !ending_; ++n) {
      v4l2_buffer next = buffer(n % kBuffers);
      if (n < kBuffers) {
        if (!call(VIDIOC_QUERYBUF, &next)) return;
        memory[n] = MappedRegion::of_file(file_.get(), next.length, next.m.offset, PROT_READ | PROT_WRITE);
        if (!memory[n].valid()) return;
      } else if (!call(VIDIOC_DQBUF, &next)) {  // waits
        return;
      }
      const std::uint32_t phase = n / 4 % (2 * kImages - 2);
      const auto& frame = frames_[phase < kImages ? phase : 2 * kImages - 2 - phase];
      std::memcpy(memory[next.index].data(), frame.data(), frame.size());
      next = buffer(next.index);
      next.bytesused = static_cast<std::uint32_t>(frame.size());
      if (!call(VIDIOC_QBUF, &next)) return;
      if (n + 1 == kBuffers && !call(VIDIOC_STREAMON, &type)) return;
    }
  }
  std::vector<std::vector<std::uint8_t>> frames_;
  UniqueFd file_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

TEST(V4l2LoopBoard, MeasuresLiveFramesWithoutHeapAndPageFaults) {
  auto input = Vivid::find(V4L2_CAP_VIDEO_CAPTURE), output = Vivid::find(V4L2_CAP_VIDEO_OUTPUT);
  if (!input || !output) GTEST_SKIP() << "no vivid device with an output: modprobe vivid node_types=0x101";
  const int hdmi = input->input_named("HDMI");
  if (hdmi < 0) GTEST_SKIP() << "vivid without an HDMI input";
  ASSERT_TRUE(input->set_input(hdmi));
  int out = 1;  // S-Video, HDMI
  if (output->port().control(VIDIOC_S_OUTPUT, &out) != 0) {
    out = 0;
    ASSERT_EQ(output->port().control(VIDIOC_S_OUTPUT, &out), 0);
  }
  v4l2_dv_timings timings = timings_640x480();
  ASSERT_EQ(input->port().control(VIDIOC_S_DV_TIMINGS, &timings), 0);
  ASSERT_EQ(output->port().control(VIDIOC_S_DV_TIMINGS, &timings), 0);
  v4l2_format format;
  std::memset(&format, 0, sizeof format);
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  format.fmt.pix.width = kWidth;
  format.fmt.pix.height = kHeight;
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  ASSERT_EQ(output->port().control(VIDIOC_S_FMT, &format), 0);
  ASSERT_EQ(format.fmt.pix.pixelformat, static_cast<std::uint32_t>(V4L2_PIX_FMT_GREY));
  ASSERT_TRUE(input->set("Percentage of Dropped Buffers", 0));
  ASSERT_TRUE(input->choose("OSD Text Mode", "None"));
  ASSERT_TRUE(input->set("Loop Video", 1));
  const std::string folder = data_folder();
  const auto player = Player::start(*output, folder);
  ASSERT_NE(player, nullptr) << "no frames in " << folder << ": set SRD_BOARD_DATA";
  std::this_thread::sleep_for(std::chrono::milliseconds(200));

  // The flume's calibration, of a taller image.
  const fakes::ScratchFolder scratch;
  std::ifstream small(folder + "/calibration.yml");
  std::string text((std::istreambuf_iterator<char>(small)), {});
  const std::string height = "image_height: 320";
  ASSERT_NE(text.find(height), std::string::npos);
  text.replace(text.find(height), height.size(), "image_height: " + std::to_string(kHeight));
  std::ofstream(scratch.path() / "calibration.yml") << text;
  const auto config = firmware::NodeConfig::parse(
      "[camera]\nsource = \"v4l2:" + input->path() + "\"\nformat = \"GREY\"\nbuffers = 6\n[geometry]\ncalibration = \"" +
          (scratch.path() / "calibration.yml").string() + "\"\npose = \"" + folder + "/pose.yml\"\npoints = \"" + folder +
          "/points.txt\"\n[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n[detector]\nregion_px = [0, 0, 640, 320]\n",
      "board.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  auto instrument = firmware::make_instrument(*config);
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  firmware::Realtime realtime({}, true);
  realtime.prepare();
  const auto started = instrument->camera->start();
  ASSERT_TRUE(started.ok()) << started.error().text();
  ASSERT_EQ(::mlockall(MCL_CURRENT | MCL_FUTURE), 0) << "run as root";

  constexpr std::uint64_t kRecords = 300, kWarm = 50;
  std::atomic<pid_t> capture_thread{0};
  std::uint64_t records = 0, near_level = 0;
  long process_before = 0, process_after = -1, capture_before = 0, capture_after = -1;
  std::atomic<firmware::FrameLoop*> running{nullptr};
  firmware::FrameLoop loop(*instrument->camera, *instrument->tracker, {}, [&](const proto::CoefficientFrame& record) {
    ++records;
    if (record.coefficients.size() > 0 && std::abs(record.coefficients[0] - 80) < 8) ++near_level;
    if (records == kWarm) {
      process_before = faults_of(this_thread());
      capture_before = faults_of(capture_thread);
    } else if (records == kRecords) {
      process_after = faults_of(this_thread());
      capture_after = faults_of(capture_thread);
      running.load()->stop();
    }
    return true;
  });
  running = &loop;
  std::int64_t taken_by_capture = -1, taken_by_process = -1;
  std::thread capture([&] {
    capture_thread = this_thread();
    const fakes::AllocationGauge gauge;
    loop.capture();
    taken_by_capture = gauge.count();
  });
  // As in srd-node a thread of its own: its stack is there as a whole, while the main thread's grows by page faults.
  std::thread process([&] {
    const fakes::AllocationGauge gauge;
    loop.process();
    taken_by_process = gauge.count();
  });
  process.join();
  capture.join();
  instrument->camera->stop();
  ::munlockall();
  EXPECT_EQ(taken_by_capture, 0);
  EXPECT_EQ(taken_by_process, 0);
  EXPECT_GE(records, kRecords);
  EXPECT_GT(near_level, records / 2) << "surfaces near the level of the scene";
  EXPECT_EQ(process_after - process_before, 0) << "page faults of the processing thread";
  EXPECT_EQ(capture_after - capture_before, 0) << "page faults of the capturing thread";
  std::printf(
      "%llu records, %llu with a surface, %llu by the source and %llu late dropped; heap %lld + %lld, page faults %ld + %ld\n",
      static_cast<unsigned long long>(records), static_cast<unsigned long long>(loop.counters().surfaces.load()),
      static_cast<unsigned long long>(loop.counters().dropped_by_source.load()),
      static_cast<unsigned long long>(loop.counters().dropped_late.load()), static_cast<long long>(taken_by_capture),
      static_cast<long long>(taken_by_process), capture_after - capture_before, process_after - process_before);
  static_cast<void>(input->set("Loop Video", 0));
}

}  // namespace
}  // namespace srd::board
