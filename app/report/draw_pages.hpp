// Pages of result folders, drawn by Python: the program measures and writes files, `ballservo.report` draws
// them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calibration/base/output.hpp"

namespace ballservo {

/// What each page is drawn from: names the page ("page": "run"), and holds what it shows and says beside the
/// tables.
inline constexpr const char* report_json_name = "report.json";

/// Draws the page of each folder of results or file of tracks with `python3 -m ballservo.report`, with
/// `figures` each figure for a paper, too, and returns why it could not, or an empty text. A page is there
/// whole or as it was. Ctrl-C ends the drawing.
std::string draw_pages(const std::vector<std::filesystem::path>& results, bool quiet, bool figures = false);

/// For a command that writes a folder's results: puts `report` (the contents of report.json) into it and
/// draws its page. Where that cannot be done it warns, and the results stand without a page.
void write_report(const OutputFolder& folder, const nlohmann::ordered_json& report, bool quiet);

/// The same for a folder that holds its report.json already; messages call it `name`.
void draw_page_or_warn(const std::filesystem::path& folder, const std::string& name, bool quiet);

/// JSON as text; bytes that are no UTF-8 (in the names of files) are replaced.
std::string report_text(const nlohmann::ordered_json& report);

}  // namespace ballservo
