// ballservo live: a page in the browser on what a camera or a recording shows.
#include <fmt/format.h>

#include <memory>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/io/interrupt.hpp"
#include "app/live/footage_session.hpp"
#include "app/live/live_server.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

struct LiveOptions {
  CommonOptions common;
  BallOptions balls;
  FootageOptions footage;
  LiveServerOptions server;
};

int run_live(LiveOptions& options) {
  FootageOptions& footage = options.footage;
  if (!(footage.fps > 0 && footage.fps <= 1000))
    throw InputError("--fps", number_text(footage.fps), "a number above 0 and up to 1000 (Hz)");
  footage.max_pixels = options.common.max_pixels;
  if (!footage.colors_output.empty())
    footage.overwrite_colors = options.common.overwrite(footage.colors_output);
  if (!footage.record.empty()) footage.overwrite_recording = options.common.overwrite(footage.record);
  if (footage.stream == standard_output && options.common.json == standard_output)
    throw InputError("--json", "stdout, where the stream goes", "the name of a file");
  LiveExchange exchange;
  FootageSession session(footage, DetectorFactory(options.balls, options.common), exchange);
  {
    const LiveServer server(options.server, exchange);
    print_result("{}\n", server.url());
    session.run();
  }
  write_json_results(options.common,
                     {{"pictures", session.pictures()}, {"interrupted", interrupt_requested()}});
  return interrupt_requested() ? exit_interrupted : exit_done;
}

}  // namespace

void add_live_command(CLI::App& program, Action& action) {
  auto options = std::make_shared<LiveOptions>();
  options->balls.taught = false;
  CLI::App* command = program.add_subcommand(
      "live", "A page in the browser: teach colours by clicking, follow balls, see why");
  command->footer(R"(Examples:
  ballservo live camera:0 -o my.colors
  ballservo live throw.mp4 --colors my.colors --camera camera.yaml --diameter 0.07 --record out/throw

Prints the page's address, and serves it until Ctrl-C (130) or the page's End (0). Click on a ball to teach its
colour; with Teach off, a click says why something is no ball. A video runs at its own pace, and again.
Only this machine reaches the page, unless --listen names another address of it: then the page's address holds
a secret, and who knows it can do what the page can.
--record keeps every picture (PNG) with its time, and the tracks: the folder is a SOURCE for detect, track and
live, also after a kill.)");
  command
      ->add_option("SOURCE", options->footage.source,
                   "A video, a folder of images or a recording, an image, or camera:N")
      ->required();
  add_ball_options(*command, options->balls);
  command->add_flag("--fixed-colors", options->footage.fixed_colors,
                    "Do not let the colours follow the light");
  command->add_option("--fps", options->footage.fps, "Times pictures that carry no time of their own (Hz)")
      ->capture_default_str();
  add_integer_option(*command, "--port", options->server.port, 0, 65535,
                     "The page's port (default 0: any free one)");
  command
      ->add_option("--listen", options->server.address,
                   "The page's IP address; 0.0.0.0: all that this machine has")
      ->type_name("ADDRESS")
      ->capture_default_str();
  add_output_option(*command, "-o,--output", options->footage.colors_output, "FILE.colors",
                    "Where the page's Save writes the colours; without it, it downloads them");
  add_output_option(*command, "--record", options->footage.record, "DIR",
                    "Keep pictures, times and tracks here");
  command
      ->add_option("--stream", options->footage.stream,
                   "Sends the tracks as `track` does; with - the address is printed on stderr")
      ->type_name("-|udp:HOST:PORT");
  add_common_options(*command, options->common);
  command->callback([options, &action] { action = [options] { return run_live(*options); }; });
}

}  // namespace ballservo
