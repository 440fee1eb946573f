#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "apps/view/layout.h"
#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {

inline bool until(const std::function<bool()>& holds, double seconds = 60.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

inline pid_t start(const std::string& command) {
  const pid_t child = fork();
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  return child;
}

inline int end_of(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// A virtual display of the size of the window.
class Display {
 public:
  explicit Display(const std::filesystem::path& folder) {
    const std::filesystem::path number = folder / "display";
    // Without -noreset the server resets when its last client leaves, and refuses connections meanwhile.
    server_ = start("Xvfb -displayfd 3 -noreset -screen 0 1280x720x24 -nolisten tcp 3>'" + number.string() +
                    "' >/dev/null 2>&1");
    if (until([&] { return bytes_of(number).ends_with('\n'); })) {
      name_ = ":" + bytes_of(number);
      name_.pop_back();
    }
  }
  ~Display() {
    kill(server_, SIGTERM);
    waitpid(server_, nullptr, 0);
  }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::string in_shell(const std::string& command) const {
    return "DISPLAY=" + name_ + " " + command;
  }

 private:
  pid_t server_ = 0;
  std::string name_;
};

/// saccade in a window on a virtual display, driven by keyboard and mouse. Skipped where Xvfb or xdotool is missing.
class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    if (run_shell("command -v Xvfb && command -v xdotool").status != 0)
      GTEST_SKIP() << "NOT TESTED: the window, Xvfb and xdotool are missing (packages xvfb, xdotool)";
    display_.emplace(folder_ / "");
    ASSERT_FALSE(display_->name().empty()) << "Xvfb does not start";
  }
  void TearDown() override {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Starts saccade and waits for its window.
  void open_window(const std::string& arguments, const std::string& title) {
    child_ = start(
        "env " + display_->in_shell("'" SACCADE_BINARY "' " + arguments + " >'" + path("output") + "' 2>&1"));
    ASSERT_TRUE(until([&] { return xdotool("search --name '" + title + "' windowfocus").status == 0; }))
        << bytes_of(path("output"));
  }
  Outcome xdotool(const std::string& what) const { return run_shell(display_->in_shell("xdotool " + what)); }
  void press(const std::string& keys) const { xdotool("key --delay 20 " + keys); }
  /// Moves the mouse to a place in the window, px, and does `then` there.
  void mouse(float x, float y, const std::string& then) const {
    xdotool("mousemove " + std::to_string(std::lround(x)) + " " + std::to_string(std::lround(y)) +
            " sleep 0.1 " + then);
  }
  /// Clicks on the timeline at a share of the recording's time.
  void click_strip(const Area& strip, double share) const {
    mouse(strip.x + static_cast<float>(share) * strip.width, strip.y + strip.height / 2, "click 1");
  }
  /// What the window shows after all input so far has taken effect; BGR.
  cv::Mat screenshot() {
    press("s");
    const std::filesystem::path folder = path("pictures");
    std::vector<std::filesystem::path> files;
    EXPECT_TRUE(until([&] {
      files.clear();
      std::error_code none_yet;
      for (const auto& entry : std::filesystem::directory_iterator(folder, none_yet)) {
        if (entry.path().extension() == ".png" && !shots_.contains(entry.path()))
          files.push_back(entry.path());
      }
      return !files.empty();
    })) << "no screenshot; output: "
        << bytes_of(path("output"));
    if (files.empty()) return cv::Mat(720, 1280, CV_8UC3, cv::Scalar::all(0));
    shots_.insert(files.front());
    newest_shot_ = files.front();
    return cv::imread(files.front().string());
  }
  /// Time of the newest screenshot, from its name.
  [[nodiscard]] std::int64_t shot_us() const {
    const std::string name = newest_shot_.filename().string();
    const std::size_t end = name.rfind("ms");
    return 1000 * std::stoll(name.substr(end - 6, 6));
  }
  void quit() {
    press("q");
    int status = 0;
    ASSERT_TRUE(until([&] { return waitpid(child_, &status, WNOHANG) == child_; }))
        << "the window does not end; output: " << bytes_of(path("output"));
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << bytes_of(path("output"));
    child_ = 0;
  }

  TempFolder folder_;
  std::optional<Display> display_;
  pid_t child_ = 0;
  std::set<std::filesystem::path> shots_;
  std::filesystem::path newest_shot_;
};

}  // namespace saccade
