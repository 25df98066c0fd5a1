// Camera files: there and back through every format, with ViSP's own parser as a witness, and everything that
// a hostile or careless file may hold.
#include "calibration/camera/files/camera_file.hpp"

#include <gtest/gtest.h>
#include <visp3/core/vpXmlParserCamera.h>

#include <nlohmann/json.hpp>

#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_formats.hpp"
#include "tests/calibration/camera_format_fixture.hpp"

namespace ballservo {
namespace {

using test::camera_examples;
using test::camera_parameters;
using test::replaced;

class CameraFiles : public test::CameraFormats {
 protected:
  /// The faults of reading such a file; empty if it was accepted.
  std::vector<Fault> faults_of(const std::string& contents) {
    return test::faults_of([&] { read_camera(file("camera.txt", contents)); });
  }
};

bool same(const CameraParameters& a, const CameraParameters& b) {
  return a.model == b.model && a.size == b.size && a.fx_px == b.fx_px && a.fy_px == b.fy_px &&
         a.cx_px == b.cx_px && a.cy_px == b.cy_px && a.coefficients == b.coefficients;
}

/// The text with other contents between an element's tags.
std::string with_element(std::string text, const std::string& name, const std::string& contents) {
  const auto start = text.find("<" + name + ">") + name.size() + 2, end = text.find("</" + name + ">");
  EXPECT_LT(start, end) << name;
  return text.replace(start, end - start, contents);
}

std::string visp_text() {
  return camera_file_text(Camera(camera_parameters(LensModel::visp, 535.1234567890123, {0.33})),
                          camera_file_format("visp", ""), "wide");
}

std::string ros_text() {
  return camera_file_text(
      Camera(camera_parameters(LensModel::brown, 533.1234567890123, {-0.28, 0.05, 1e-3, -5e-4, 0.09})),
      camera_file_format("ros", ""), "wide");
}

TEST_F(CameraFiles, EveryFormatKeepsEveryBitOfWhatItHolds) {
  for (const CameraFileFormat& format : camera_file_formats()) {
    for (const auto& example : camera_examples()) {
      CameraParameters p = example.parameters;
      p.fx_px += 1.0 / 3, p.cy_px -= 1.0 / 7;
      const Camera camera(p);
      const bool held = std::find(format.models.begin(), format.models.end(), p.model) != format.models.end();
      if (!format.partly.empty() && p.model == format.partly.front()) continue;
      if (!held) {
        try {
          camera_file_text(camera, format, "camera");
          ADD_FAILURE() << format.name << " took " << example.name;
        } catch (const InputError& error) {
          EXPECT_EQ(error.faults().front().found, lens_model_name(p.model));
        }
        continue;
      }
      const std::string name = file("written.any", camera_file_text(camera, format, "cam0"));
      EXPECT_TRUE(same(read_camera(name).parameters(), p)) << format.name << " " << example.name;
      EXPECT_TRUE(same(read_camera(name + ":cam0").parameters(), p));
      EXPECT_THROW(read_camera(name + ":other"), InputError);
    }
  }
}

TEST_F(CameraFiles, VispReadsWhatWeWrite) {
  for (const auto& example : camera_examples()) {
    const CameraParameters& p = example.parameters;
    vpCameraParameters::vpCameraParametersProjType type;
    if (p.model == LensModel::pinhole)
      type = vpCameraParameters::perspectiveProjWithoutDistortion;
    else if (p.model == LensModel::visp)
      type = vpCameraParameters::perspectiveProjWithDistortion;
    else if (p.model == LensModel::kannala_brandt)
      type = vpCameraParameters::ProjWithKannalaBrandtDistortion;
    else
      continue;
    const std::string name =
        file("camera.xml", camera_file_text(Camera(p), camera_file_format("visp", ""), "eye"));
    vpCameraParameters visp;
    vpXmlParserCamera parser;
    ASSERT_EQ(parser.parse(visp, name, "eye", type, 640, 480), vpXmlParserCamera::SEQUENCE_OK);
    EXPECT_EQ(visp.get_px(), p.fx_px);
    EXPECT_EQ(visp.get_v0(), p.cy_px);
    if (p.model == LensModel::visp) {
      EXPECT_EQ(visp.get_kdu(), p.coefficients[0]);
    }
    if (p.model == LensModel::kannala_brandt) {
      EXPECT_EQ(visp.getKannalaBrandtDistortionCoefficients()[3], p.coefficients[3]);
    }
  }
}

TEST_F(CameraFiles, OneCameraOfSeveral) {
  const std::string name = (folder_.path() / "two.xml").string();
  vpCameraParameters visp;
  visp.initPersProjWithoutDistortion(600.25, 601, 320, 240);
  ASSERT_EQ(vpXmlParserCamera().save(visp, name, "left", 640, 480), vpXmlParserCamera::SEQUENCE_OK);
  visp.initPersProjWithDistortion(700.25, 701, 320, 240, -0.1, 0.1);
  ASSERT_EQ(vpXmlParserCamera().save(visp, name, "right", 640, 480), vpXmlParserCamera::SEQUENCE_OK);
  EXPECT_EQ(read_camera(name + ":left").parameters().fx_px, 600.25);
  EXPECT_EQ(read_camera(name + ":left").parameters().model, LensModel::pinhole);
  EXPECT_EQ(read_camera(name + ":right").parameters().fx_px, 700.25);
  const std::string fault = test::fault_lines([&] { read_camera(name); });
  EXPECT_NE(fault.find("\"left\""), std::string::npos) << fault;
  EXPECT_NE(fault.find("\"right\""), std::string::npos) << fault;
  // Of several models of one camera, the one with distortion.
  visp.initPersProjWithDistortion(605.25, 606, 320, 240, -0.1, 0.1);
  ASSERT_EQ(vpXmlParserCamera().save(visp, name, "left", 640, 480), vpXmlParserCamera::SEQUENCE_OK);
  EXPECT_EQ(read_camera(name + ":left").parameters().fx_px, 605.25);
}

TEST_F(CameraFiles, VispNumbersThatVispWouldTake) {
  for (const char* value : {"nan", "-inf", "inf", "-535", "0", "", "twelve", "535,5", "1e999", "0x20"}) {
    const auto faults = faults_of(with_element(visp_text(), "px", value));
    ASSERT_EQ(faults.size(), 1u) << value;
    EXPECT_NE(faults.front().place.find(":19: px"), std::string::npos) << faults.front().place;
  }
}

TEST_F(CameraFiles, VispFaultsAllAtOnce) {
  std::string text = with_element(visp_text(), "px", "nan</px><lens>3</lens><px>1");
  text = replaced(text, "<px>1</px>", "");
  text = replaced(with_element(text, "u0", ""), "<u0></u0>", "");
  text = replaced(text, "<image_width>640<", "<image_width>0<");
  EXPECT_EQ(faults_of(text).size(), 4u);
}

TEST_F(CameraFiles, KudThatContradictsKdu) {
  EXPECT_EQ(faults_of(with_element(visp_text(), "kdu", "-0.33")).size(), 1u);
  const auto faults = faults_of(with_element(visp_text(), "kdu", "0"));
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults.front().found.find("kdu = 0"), std::string::npos);
}

TEST(VispKud, UndoesKduAsWellAsItCan) {
  CameraParameters p = camera_parameters(LensModel::visp, 535, {0.1});
  const Camera camera(p);
  const double best = best_kud(p);
  EXPECT_LT(best, 0);
  const auto squared_error = [&](double kud) {
    double sum = 0;
    for (double v = 0; v <= 479; v += 479.0 / 40)
      for (double u = 0; u <= 639; u += 639.0 / 40) {
        const Eigen::Vector3d ray = *camera.unproject({u, v});
        const Eigen::Vector2d x = ray.head<2>() / ray.z();
        const Eigen::Vector2d m = x * (1 + kud * x.squaredNorm());
        sum += (Eigen::Vector2d(p.cx_px + p.fx_px * m.x(), p.cy_px + p.fy_px * m.y()) - Eigen::Vector2d(u, v))
                   .squaredNorm();
      }
    return sum;
  };
  EXPECT_LT(squared_error(best), squared_error(best + 1e-3));
  EXPECT_LT(squared_error(best), squared_error(best - 1e-3));
}

TEST_F(CameraFiles, XmlThatIsNoneOrTooClever) {
  const std::string text = visp_text();
  for (const std::string& bad :
       {std::string(), std::string("<"), std::string("<root>"), std::string("<root></camera></root>"),
        std::string("<!DOCTYPE root [<!ENTITY a \"b\">]><root/>"), std::string("<root>&a;</root>"),
        std::string("<svg></svg>"), std::string("<root></root>"), std::string("\x89PNG\r\n\x1a\n\0\0", 10),
        std::string("<root><camera></camera></root>"), text + "<root/>", text + text,
        replaced(text, "<type>perspectiveProjWithDistortion</type>", "<type>fisheye</type>"),
        replaced(text, "<type>perspectiveProjWithDistortion</type>", ""),
        replaced(text, "<image_height>480</image_height>", ""), replaced(text, "<v0>", "<v0>1</v0><v0>")})
    EXPECT_FALSE(faults_of(bad).empty()) << bad.substr(0, 60);
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<root>";
  EXPECT_FALSE(faults_of(deep).empty());
  for (std::size_t end = 0; end < text.size() - 8; end += 7)
    EXPECT_FALSE(faults_of(text.substr(0, end)).empty()) << "cut at " << end;
}

TEST_F(CameraFiles, RosAsItsOwnToolsWriteIt) {
  const auto name = file("ros.yaml", R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [438.78361, 0.0, 305.59383, 0.0, 437.30282, 243.73835, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.999978, 0.002789, -0.006046, -0.002816, 0.999986, -0.004401, 0.006034, 0.004417, 0.999972]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.653800, 0.0, 322.797939, 0.0, 0.0, 393.653800, 241.090902, 0.0, 0.0, 0.0, 1.0, 0.0]
)");
  const auto p = read_camera(name).parameters();
  EXPECT_EQ(p.model, LensModel::brown);
  EXPECT_EQ(p.fx_px, 438.78361);
  EXPECT_EQ(p.cy_px, 243.73835);
  EXPECT_EQ(p.coefficients[3], 0.000505);
  EXPECT_NO_THROW(read_camera(name + ":narrow_stereo/left"));
}

TEST_F(CameraFiles, RosFaults) {
  const std::string text = ros_text();
  const std::string number = "533.1234567890123";
  for (const std::string& bad : {replaced(text, number, ".nan"),
                                 replaced(text, number, ".inf"),
                                 replaced(text, number, "-533"),
                                 replaced(text, number, "0"),
                                 replaced(text, number, "many"),
                                 replaced(text, number + ", 0", number),
                                 replaced(text, number + ", 0", number + ", 0.1"),
                                 replaced(text, "plumb_bob", "fisheye"),
                                 replaced(text, "plumb_bob", "equidistant"),
                                 replaced(text, "plumb_bob", "rational_polynomial"),
                                 replaced(text, "image_width: 640", "image_width: 0"),
                                 replaced(text, "image_width: 640", "image_width: 640.5"),
                                 replaced(text, "image_width: 640\n", ""),
                                 replaced(text, "image_width: 640\n", "image_width: 640\nimage_width: 640\n"),
                                 replaced(text, "camera_name", "camera_nane"),
                                 replaced(text, "cols: 5", "cols: 4"),
                                 replaced(text, "camera_matrix:\n  rows: 3", "camera_matrix:\n  rows: 4"),
                                 replaced(text, "-0.28", ".nan"),
                                 text + "\n---\n" + text,
                                 text.substr(0, text.find("distortion_model"))})
    EXPECT_FALSE(faults_of(bad).empty()) << bad.substr(0, 300);
}

TEST_F(CameraFiles, RosFaultsAllAtOnceWithTheirLines) {
  std::string text = replaced(ros_text(), "533.1234567890123", "-533");
  text = replaced(text, "image_height: 480", "image_height: minus");
  text = replaced(text, "camera_name", "camera_nane");
  const auto faults = faults_of(text);
  ASSERT_GE(faults.size(), 3u);
  int with_line_2 = 0;
  for (const Fault& fault : faults)
    with_line_2 += fault.place.find("camera.txt:2: image_height") != std::string::npos;
  EXPECT_EQ(with_line_2, 1);
}

TEST_F(CameraFiles, OtherFilesAreNotCameras) {
  for (const std::string& bad : {std::string(), std::string("hello"), std::string(2u << 20, ' ')})
    EXPECT_EQ(faults_of(bad).size(), 1u);
  EXPECT_THROW(read_camera((folder_.path() / "missing.xml").string()), InputError);
  EXPECT_THROW(read_camera(folder_.path().string()), InputError);
}

TEST(CameraFileNames, FormatsByExtensionAndByName) {
  EXPECT_EQ(camera_file_format("", "a/left.xml").name, "visp");
  EXPECT_EQ(camera_file_format("", "left.yaml").name, "ros");
  EXPECT_EQ(camera_file_format("ros", "left.xml").name, "ros");
  EXPECT_THROW(camera_file_format("", "left"), InputError);
  EXPECT_THROW(camera_file_format("", "left.png"), InputError);
  EXPECT_THROW(camera_file_format("matlab", "left.xml"), InputError);
}

TEST(CameraFits, OnlyItsOwnSize) {
  const Camera camera(camera_parameters(LensModel::pinhole, 500, {}));
  EXPECT_NO_THROW(check_camera_fits(camera, {640, 480}, "camera.xml"));
  EXPECT_THROW(check_camera_fits(camera, {480, 640}, "camera.xml"), InputError);
  EXPECT_THROW(check_camera_fits(camera, {640, 481}, "camera.xml"), InputError);
}

class CovarianceFiles : public CameraFiles {
 protected:
  Eigen::MatrixXd example() {
    Eigen::MatrixXd root(5, 5);
    for (int i = 0; i < 25; ++i) root(i / 5, i % 5) = std::sin(1.7 * i * i) * (i / 5 == 4 ? 1e-4 : 1);
    return root * root.transpose();
  }
  const Camera camera{camera_parameters(LensModel::visp, 535, {0.33})};
};

TEST_F(CovarianceFiles, ThereAndBack) {
  const std::string name = (folder_.path() / "camera.xml").string();
  EXPECT_FALSE(read_camera_covariance(name, camera));
  const std::string text = camera_covariance_text(camera, example());
  EXPECT_EQ(nlohmann::json::parse(text)["parameters"],
            nlohmann::json({"fx_px", "fy_px", "cx_px", "cy_px", "kdu"}));
  file("camera.xml.covariance.json", text);
  EXPECT_EQ(read_camera_covariance(name, camera), example());
  // Another camera's, for instance after the camera file was edited: not used.
  EXPECT_FALSE(read_camera_covariance(name, Camera(camera_parameters(LensModel::visp, 536, {0.33}))));
  EXPECT_FALSE(read_camera_covariance(name, Camera(camera_parameters(LensModel::pinhole, 535, {}))));
}

TEST_F(CovarianceFiles, DamagedOnes) {
  const std::string text = camera_covariance_text(camera, example());
  Eigen::MatrixXd indefinite = example();
  indefinite(0, 0) = -1;
  Eigen::MatrixXd skew = example();
  skew(0, 1) += 1;
  for (const std::string& bad :
       {std::string(), std::string("[]"), std::string("{}"), text.substr(0, text.size() / 2),
        camera_covariance_text(camera, indefinite), camera_covariance_text(camera, skew),
        camera_covariance_text(camera, Eigen::MatrixXd::Identity(3, 3)),
        camera_covariance_text(camera, Eigen::MatrixXd::Constant(5, 5, std::nan(""))),
        replaced(text, "\"covariance\": [", "\"covariance\": [1e999,"),
        replaced(text, "\"values\"", "\"vals\"")}) {
    file("camera.xml.covariance.json", bad);
    EXPECT_THROW(read_camera_covariance((folder_.path() / "camera.xml").string(), camera), InputError)
        << bad.substr(0, 80);
  }
}

}  // namespace
}  // namespace ballservo
