// ballservo report: draws the pages of result folders again.

#include "app/commands/command.hpp"
#include "app/io/interrupt.hpp"
#include "app/report/draw_pages.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

struct ReportOptions {
  CommonOptions common;
  std::vector<std::filesystem::path> results;
  bool figures = false;
};

/// Where the page and the figures of results lie: in their folder, or beside the file of tracks.
struct Drawn {
  std::filesystem::path page, figures;
};

Drawn drawn(const std::filesystem::path& results) {
  if (std::filesystem::is_directory(results)) return {results / "report.html", results / "figures"};
  const std::filesystem::path stem = results.parent_path() / results.stem();
  return {stem.string() + ".html", stem.string() + "_figures"};
}

int draw_reports(const ReportOptions& options) {
  FaultList faults;
  for (const std::filesystem::path& results : options.results) {
    if (!std::filesystem::is_regular_file(results) &&
        !std::filesystem::is_regular_file(results / report_json_name))
      faults.add(results.string(), "no file, and no report.json in it",
                 "a folder that servo, sweep, compare or calibrate wrote, or a file that track wrote");
    const std::filesystem::path figures = drawn(results).figures;
    if (options.figures && !options.common.force && std::filesystem::exists(figures))
      faults.add(figures.string(), "there already, and its scripts may have been changed",
                 "--force to write it anew");
  }
  faults.throw_if_any();
  const std::string why = draw_pages(options.results, options.common.quiet, options.figures);
  throw_if_interrupted();
  if (!why.empty())
    throw InputError(
        "report.html", why,
        "results with something to draw, as servo, sweep, compare, calibrate or track wrote them");
  nlohmann::json pages = nlohmann::json::array();
  for (const std::filesystem::path& results : options.results) {
    pages.push_back(std::filesystem::absolute(drawn(results).page).lexically_normal().string());
    print_result("{}\n", pages.back().get<std::string>());
  }
  write_json_results(options.common, {{"pages", pages}});
  return exit_done;
}

}  // namespace

void add_report_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<ReportOptions>(
      program, action, "report", "Draw the pages of results again, or of tracks", draw_reports);
  command.footer(R"(Example:
  ballservo report run sweep
  ballservo report run --figures && python3 run/figures/clearance.py
  ballservo report tracks.csv

Draws report.html of each folder from the other files in it, in place of the one that is there, and prints
where it lies. Of a file as `track -o tracks.csv` writes it tracks.html is drawn, beside it: ways, distances, heights,
states. Needs Debian's python3-matplotlib and python3-jinja2. --figures puts into DIR/figures (tracks_figures) each
figure of the page for a paper: NAME.svg and NAME.pdf, 85 mm wide, and NAME.py, the short script that draws both, to
be changed.
Exit: 0 drawn, 2 no results of this program, or nothing to draw with.)");
  command.add_option("DIR|FILE", options.results, "Folders of results, files of tracks")->required();
  command.add_flag("--figures", options.figures,
                   "Each figure as SVG and PDF for a paper, too, with its script");
  add_common_options(command, options.common);
}

}  // namespace ballservo
