// The ball of data/scenarios/lighting_change.yaml, tracked by the program through pictures of the program,
// with colours that follow the light and with fixed ones, against truth.csv.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "tests/program/csv_rows.hpp"
#include "tests/support/test_data.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

using test::number;
using test::Row;

void run(const fs::path& folder, const std::string& arguments) {
  const std::string command =
      fmt::format("cd '{}' && '{}' {} --quiet", folder.string(), BALLSERVO_PROGRAM, arguments);
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command;
}

struct Score {
  int visible = 0, tracked = 0, elsewhere = 0;
};

/// In how many of the pictures that show the target a row claims it; and the confirmed claims of other
/// places.
Score score(const fs::path& tracks, const fs::path& truth) {
  std::map<std::string, Row> target;
  for (const Row& row : test::read_csv(truth)) {
    if (row.at("ball_id") == "target" && number(row, "visible_fraction") > 0.5)
      target[row.at("source")] = row;
  }
  Score result;
  result.visible = static_cast<int>(target.size());
  std::map<std::string, bool> tracked;
  for (const Row& row : test::read_csv(tracks)) {
    if (row.at("state") == "coasting") continue;
    const auto true_row = target.find(row.at("source"));
    const bool there =
        true_row != target.end() && std::hypot(number(row, "cx_px") - number(true_row->second, "cx_px"),
                                               number(row, "cy_px") - number(true_row->second, "cy_px")) <
                                        0.3 * number(true_row->second, "r_px");
    if (there) tracked[row.at("source")] = true;
    if (!there && row.at("state") == "confirmed") ++result.elsewhere;
  }
  result.tracked = static_cast<int>(tracked.size());
  return result;
}

TEST(LightingChange, TheBallIsKeptThoughTheLightChanges) {
  const test::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  const fs::path data = test::project_data_dir();
  const std::string colors = (data / "colors" / "orange.colors").string();
  run(folder, fmt::format("render '{}' -o light --frames {} --set camera.rate_hz={}",
                          (data / "scenarios" / "lighting_change.yaml").string(), 30 * BALLSERVO_RATE_HZ,
                          BALLSERVO_RATE_HZ));
  const auto track = [&](const char* name, const char* option) {
    run(folder,
        fmt::format("track light --fps {} --colors '{}' -o {} {}", BALLSERVO_RATE_HZ, colors, name, option));
    return score(folder / name, folder / "light" / "truth.csv");
  };
  const Score following = track("following.csv", ""), fixed = track("fixed.csv", "--fixed-colors");
  ASSERT_EQ(following.visible, 30 * BALLSERVO_RATE_HZ);
  EXPECT_GE(following.tracked, 0.99 * following.visible);
  EXPECT_LE(5 * (following.visible - following.tracked), fixed.visible - fixed.tracked);
  EXPECT_EQ(following.elsewhere, 0);
  RecordProperty("tracked", following.tracked);
  RecordProperty("tracked_by_fixed_colors", fixed.tracked);
}

}  // namespace
}  // namespace ballservo
