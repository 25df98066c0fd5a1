// What clients of the live page say: a message a line, each done to a scenario as far as it touches one, or
// to colours or boards that it holds. What has been done is written down, and read again.
#include <sstream>

#include "app/experiment/touches.hpp"
#include "app/live/client_words.hpp"
#include "calibration/boards/board.hpp"
#include "calibration/color/color_file.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scenario untouched =
      load_scenario(std::filesystem::path(BALLSERVO_DATA_DIR) / "scenarios" / "obstacles.yaml", {}, 1);
  static const fuzz::Folder folder(BALLSERVO_DATA_DIR);
  Scenario scenario = untouched;
  Touches touches;
  std::istringstream lines(fuzz::text_of(data, size));
  for (std::string line; std::getline(lines, line);) {
    const auto what = message_of(line);
    if (!what) continue;
    const auto say = [](nlohmann::json said) {
      said.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    };
    const auto done = [&]() -> nlohmann::json {
      const auto touch = what->find("touch");
      if (touch != what->end()) {
        touches.list.push_back(parse_touch(touch->dump(), touches.steps++, untouched, scenario));
        touch_scenario(touches.list.back(), untouched, scenario);
      }
      if (what->contains("board"))
        parse_board(text_at(*what, "board"), length_m_at(*what, "square_m", "side", 0.001, 1));
      if (const auto bytes = from_base64(text_at(*what, "base64")); bytes && !bytes->empty()) {
        fuzz::require(from_base64(base64(*bytes)) == bytes, "bytes that come back as they were sent");
        parse_color_file(*bytes, "the file");
      }
      return {{"u_px", number_at(*what, "u_px", -1)}};
    };
    answer({*what, say}, [&]() -> nlohmann::json {
      try {
        return done();
      } catch (const InputError&) {
        throw;
      } catch (const Refusal&) {
        throw;
      } catch (const std::exception& error) {
        fuzz::require(false, error.what());  // that a client would be told so hides a fault
        throw;
      }
    });
  }
  if (touches.list.empty()) return 0;
  const std::string text = touches_yaml(touches);
  fuzz::require(touches_yaml(read_touches(folder.file("touches.yaml", text), untouched)) == text,
                "touches that read back as they were written");
  return 0;
}
