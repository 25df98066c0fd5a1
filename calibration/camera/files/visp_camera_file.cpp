#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <visp3/core/vpCameraParameters.h>
#include <visp3/core/vpXmlParserCamera.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/output.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_formats.hpp"

namespace ballservo {
namespace {

// The little of XML that camera files need, read by libxml2: elements and text. Document types are refused,
// and with them entities of a file's own (a small file could unfold without bound).

std::string line_of(const std::string& name, long line) { return name + ":" + std::to_string(line); }

std::string name_of(const xmlNode* element) { return reinterpret_cast<const char*>(element->name); }

/// Of the element itself, entities replaced, surrounding blanks removed.
std::string text_of(const xmlNode* element) {
  std::string text;
  for (const xmlNode* child = element->children; child; child = child->next)
    if (child->type == XML_TEXT_NODE || child->type == XML_CDATA_SECTION_NODE)
      text += reinterpret_cast<const char*>(child->content);
  return std::string(trimmed(text));
}

using XmlDocument = std::unique_ptr<xmlDoc, void (*)(xmlDoc*)>;

/// InputError (with line) for what is not well-formed. `name` stands for the file.
XmlDocument parse_xml(const std::string& text, const std::string& name) {
  const std::unique_ptr<xmlParserCtxt, void (*)(xmlParserCtxt*)> parser(xmlNewParserCtxt(),
                                                                        xmlFreeParserCtxt);
  XmlDocument document(
      xmlCtxtReadMemory(parser.get(), text.data(), static_cast<int>(text.size()), name.c_str(), nullptr,
                        XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING),
      xmlFreeDoc);
  if (!document) {
    const xmlError* error = xmlCtxtGetLastError(parser.get());
    const std::string found(error && error->message ? trimmed(error->message) : "no XML");
    throw InputError(line_of(name, error ? error->line : 1), found, "a well-formed XML document");
  }
  if (document->intSubset) throw InputError(name, "a document type", "elements, text and comments only");
  return document;
}

struct VispModel {
  std::string_view type;
  LensModel model;
  std::vector<std::string_view> coefficients;  // entries of the file, beside px py u0 v0
};

/// The fullest model of a camera comes first.
const std::vector<VispModel>& visp_models() {
  static const std::vector<VispModel> models{
      {"ProjWithKannalaBrandtDistortion", LensModel::kannala_brandt, {"k1", "k2", "k3", "k4", "k5"}},
      {"perspectiveProjWithDistortion", LensModel::visp, {"kud", "kdu"}},
      {"perspectiveProjWithoutDistortion", LensModel::pinhole, {}}};
  return models;
}

/// What the text of one <camera> says, before any of it is believed.
struct CameraEntry {
  std::string name;
  ImageSize size;
  struct Model {
    const VispModel* kind = nullptr;
    std::map<std::string, double> values;
    long line = 0;
  };
  std::vector<Model> models;
};

/// Reads the checked text; everything that is wrong with it becomes a fault.
class EntryReader {
 public:
  EntryReader(std::string file, FaultList& faults) : file_(std::move(file)), faults_(faults) {}

  std::vector<CameraEntry> cameras(xmlNode* root) {
    std::vector<CameraEntry> result;
    if (name_of(root) != "root") fault(root, "<" + name_of(root) + ">", "<root>, as ViSP writes it");
    for (xmlNode* child = xmlFirstElementChild(root); child; child = xmlNextElementSibling(child)) {
      if (name_of(child) == "camera")
        result.push_back(camera(child));
      else
        fault(child, "<" + name_of(child) + ">", "<camera>");
    }
    if (name_of(root) == "root" && !xmlFirstElementChild(root))
      fault(root, "no camera", "at least one <camera>");
    return result;
  }

 private:
  void fault(xmlNode* element, const std::string& found, const std::string& allowed) {
    faults_.add(fmt::format("{}:{}: {}", file_, xmlGetLineNo(element), name_of(element)), found, allowed);
  }

  int whole_number(xmlNode* element) {
    const auto value = parse_integer(text_of(element));
    if (value && *value >= 1 && *value <= 65536) return static_cast<int>(*value);
    fault(element, "\"" + text_of(element) + "\"", "a whole number from 1 to 65536");
    return 0;
  }

  CameraEntry camera(xmlNode* element) {
    CameraEntry entry;
    std::map<std::string, int> seen;
    for (xmlNode* child = xmlFirstElementChild(element); child; child = xmlNextElementSibling(child)) {
      const std::string name = name_of(child);
      if (name == "model") {
        entry.models.push_back(model(child));
      } else if (name != "additional_information" && seen[name]++) {
        fault(child, "<" + name + "> a second time", "one");
      } else if (name == "name") {
        entry.name = text_of(child);
      } else if (name == "image_width") {
        entry.size.width_px = whole_number(child);
      } else if (name == "image_height") {
        entry.size.height_px = whole_number(child);
      } else if (name == "subsampling_width" || name == "subsampling_height") {
        whole_number(child);
      } else if (name != "additional_information") {
        fault(child, "<" + name + ">", "name, image_width, image_height, model");
      }
    }
    for (const char* size : {"image_width", "image_height"})
      if (!seen[size]) fault(element, fmt::format("no <{}>", size), "the size of the camera's pictures");
    if (entry.models.empty()) fault(element, "no <model>", "at least one");
    return entry;
  }

  CameraEntry::Model model(xmlNode* element) {
    CameraEntry::Model result;
    result.line = xmlGetLineNo(element);
    xmlNode* type = xmlFirstElementChild(element);
    while (type && name_of(type) != "type") type = xmlNextElementSibling(type);
    std::string types;
    for (const VispModel& kind : visp_models()) {
      if (type && text_of(type) == kind.type) result.kind = &kind;
      types += fmt::format("{}{}", types.empty() ? "" : ", ", kind.type);
    }
    if (!result.kind) {
      fault(element, type ? "type \"" + text_of(type) + "\"" : "no <type>", types);
      return result;
    }
    std::vector<std::string_view> keys{"px", "py", "u0", "v0"};
    keys.insert(keys.end(), result.kind->coefficients.begin(), result.kind->coefficients.end());
    for (xmlNode* child = xmlFirstElementChild(element); child; child = xmlNextElementSibling(child)) {
      const std::string name = name_of(child);
      if (child == type) continue;
      if (std::find(keys.begin(), keys.end(), name) == keys.end()) {
        fault(child, "<" + name + ">", fmt::format("type, {}", fmt::join(keys, ", ")));
        continue;
      }
      const auto value = parse_number(text_of(child));
      if (!value) fault(child, "\"" + text_of(child) + "\"", "a finite number");
      if (value && (name == "px" || name == "py") && *value <= 0)
        fault(child, text_of(child), "a number above 0 (px)");
      if (!result.values.emplace(name, value.value_or(1)).second)
        fault(child, "<" + name + "> a second time", "one");
    }
    for (const std::string_view key : keys)
      if (!result.values.count(std::string(key))) fault(element, fmt::format("no <{}>", key), "a number");
    return result;
  }

  std::string file_;
  FaultList& faults_;
};

CameraParameters parameters_of(const CameraEntry& entry, const CameraEntry::Model& model) {
  CameraParameters parameters;
  parameters.model = model.kind->model;
  parameters.size = entry.size;
  parameters.fx_px = model.values.at("px"), parameters.fy_px = model.values.at("py");
  parameters.cx_px = model.values.at("u0"), parameters.cy_px = model.values.at("v0");
  std::size_t i = 0;
  for (const std::string& name : coefficient_names(parameters.model))
    parameters.coefficients[i++] = model.values.at(name);
  return parameters;
}

/// kud and kdu describe one lens; where they contradict each other nobody can know which is right.
void check_kud(const CameraParameters& p, double kud, const std::string& place) {
  const double kdu = p.coefficients[0];
  // The corner furthest from the principal point, in normalised units; r is the distorted radius there.
  const double x = std::max(p.cx_px, p.size.width_px - 1 - p.cx_px) / p.fx_px;
  const double y = std::max(p.cy_px, p.size.height_px - 1 - p.cy_px) / p.fy_px;
  const double r = std::hypot(x, y), undistorted = r * (1 + kdu * r * r);
  const double focal = std::sqrt(p.fx_px * p.fy_px);
  const double by_kdu_px = focal * (undistorted - r);
  const double by_kud_px = -focal * kud * undistorted * undistorted * undistorted;
  const double difference_px = std::abs(by_kdu_px - by_kud_px);
  if ((kdu == 0 && kud != 0) ||
      !(difference_px <= 2 + 0.5 * std::max(std::abs(by_kdu_px), std::abs(by_kud_px))))
    throw InputError(place,
                     fmt::format("kdu = {} and kud = {}, which disagree by {:.1f} px in the corner", kdu, kud,
                                 difference_px),
                     fmt::format("two coefficients of one lens (about {:.6g} as kud)", best_kud(p)));
}

bool is_visp_text(std::string_view text) {
  const std::string_view start = trimmed(text);
  return start.substr(0, 1) == "<" && start.substr(0, 2) != "<<" &&
         text.find("<opencv_storage") == std::string_view::npos;
}

Camera read_visp(const std::filesystem::path& file, const std::string& text, const std::string& camera_name) {
  FaultList faults;
  const XmlDocument document = parse_xml(text, file.string());
  const auto entries = EntryReader(file.string(), faults).cameras(xmlDocGetRootElement(document.get()));
  faults.throw_if_any();
  std::vector<const CameraEntry*> meant;
  std::string known;
  for (const CameraEntry& entry : entries) {
    if (camera_name.empty() || entry.name == camera_name) meant.push_back(&entry);
    known += fmt::format("{}\"{}\" ({}x{})", known.empty() ? "" : ", ", entry.name, entry.size.width_px,
                         entry.size.height_px);
  }
  if (meant.empty())
    throw InputError(file.string(), "no camera \"" + camera_name + "\"", "one of its cameras: " + known);
  if (meant.size() > 1)
    throw InputError(file.string(), "several cameras: " + known,
                     camera_name.empty() ? "FILE:NAME says which one is meant" : "one camera of that name");
  const CameraEntry& entry = *meant.front();
  const auto fuller = [](const CameraEntry::Model& a, const CameraEntry::Model& b) {
    return a.kind < b.kind;
  };
  const CameraEntry::Model& model = *std::min_element(entry.models.begin(), entry.models.end(), fuller);
  const std::string place = line_of(file.string(), model.line);
  if (std::count_if(entry.models.begin(), entry.models.end(),
                    [&](const CameraEntry::Model& other) { return other.kind == model.kind; }) > 1)
    throw InputError(place, fmt::format("{} twice in one camera", model.kind->type), "one");
  // The numbers are the text's own: ViSP's reader follows the process's locale.
  const CameraParameters parameters = parameters_of(entry, model);
  const Camera camera(parameters, place);
  if (model.kind->model == LensModel::visp) check_kud(parameters, model.values.at("kud"), place);
  return camera;
}

vpCameraParameters visp_parameters(const CameraParameters& p) {
  vpCameraParameters result;
  if (p.model == LensModel::pinhole)
    result.initPersProjWithoutDistortion(p.fx_px, p.fy_px, p.cx_px, p.cy_px);
  else if (p.model == LensModel::visp)
    result.initPersProjWithDistortion(p.fx_px, p.fy_px, p.cx_px, p.cy_px, best_kud(p), p.coefficients[0]);
  else
    result.initProjWithKannalaBrandtDistortion(
        p.fx_px, p.fy_px, p.cx_px, p.cy_px,
        {p.coefficients[0], p.coefficients[1], p.coefficients[2], p.coefficients[3], 0.0});
  return result;
}

std::string write_visp(const Camera& camera, const std::string& camera_name) {
  const CameraParameters& p = camera.parameters();
  // Onto a file that already holds this camera ViSP's writer fails: a new one each time.
  const TemporaryFolder folder;
  const auto file = folder.path() / "camera.xml";
  const int verdict = vpXmlParserCamera().save(visp_parameters(p), file.string(), camera_name,
                                               static_cast<unsigned>(p.size.width_px),
                                               static_cast<unsigned>(p.size.height_px));
  if (verdict != vpXmlParserCamera::SEQUENCE_OK)
    throw InputError(file.string(), "ViSP's writer failed", "a writable temporary folder (TMPDIR)");
  const std::string text = read_file_bytes(file, 1u << 20);
  // ViSP's writer follows the process's locale: make sure that what it wrote is what was meant.
  if (parameter_vector(read_visp(file, text, "").parameters()) != parameter_vector(p))
    throw InputError(file.string(), "numbers changed by ViSP's writer", "the C locale");
  return text;
}

}  // namespace

double best_kud(const CameraParameters& p) {
  // x (1 + kud |x|^2) should be m where x = m (1 + kdu |m|^2): linear in kud.
  constexpr int steps = 40;
  double numerator = 0, denominator = 0;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const double mx = ((p.size.width_px - 1.0) * i / steps - p.cx_px) / p.fx_px;
      const double my = ((p.size.height_px - 1.0) * j / steps - p.cy_px) / p.fy_px;
      const double scale = 1 + p.coefficients[0] * (mx * mx + my * my);
      const double x = mx * scale, y = my * scale, r2 = x * x + y * y;
      const double ax = p.fx_px * x * r2, ay = p.fy_px * y * r2;
      numerator += ax * p.fx_px * (mx - x) + ay * p.fy_px * (my - y);
      denominator += ax * ax + ay * ay;
    }
  }
  return denominator > 0 ? numerator / denominator : 0;
}

CameraFileFormat visp_camera_format() {
  return {
      "visp",       "ViSP XML", {".xml"},  {LensModel::pinhole, LensModel::visp, LensModel::kannala_brandt},
      is_visp_text, read_visp,  write_visp};
}

}  // namespace ballservo
