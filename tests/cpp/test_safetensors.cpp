// The model file: what is written can be read by anyone, and nothing that is read is trusted.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "graspctx/error.hpp"
#include "graspctx/grasp_model.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

using testing::tiny_descriptor;
using testing::uniform;
using Bytes = std::vector<std::uint8_t>;

/// A model with every field away from its default.
GraspModel handmade_model() {
  GraspModel model;
  model.name = "mug \"quoted\" ü";
  model.classes = {"mug", "tea cup", "a,b"};
  for (int i = 3; i < 12; ++i) model.classes.push_back("class " + std::to_string(i));  // 10 sorts before 2
  model.provenance = {{"command", "train --x 'y' {\"z\": 1}"}, {"training.rows", "12"}, {"empty", ""}};
  DescriptorOptions& d = model.descriptor;
  d = tiny_descriptor();
  d.fovea.object_px = 180;
  d.fovea.margin_px = 30;
  d.contour.canny_low = 0.1;
  d.contour.canny_high = 61.000000000000007;
  d.contour.samples = 0;
  d.contour.mask_margin_px = 3;
  d.shape_context.inner_radius = 1.0 / 3;
  d.shape_context.outer_radius = 2.5;
  d.shape_context.relative_to_gradient = true;
  d.patch.patch_px = 12;
  d.patch.windows_patches = {3, 5, 11};
  model.mean = Eigen::Vector3f(0.1f, -0.0f, 1e-20f);
  model.scale = Eigen::Vector3f(1.0f / 3, 1e-38f, 3e38f);
  model.svm_c = 10.0 / 3;
  model.gamma = 1e-7 / 3;
  model.rho = -0.1;
  model.sigmoid_a = -2.0 / 3;
  model.sigmoid_b = 5e-324;
  model.support_vectors.resize(4, 3);
  model.support_vectors << 1, 2, 3, -0.0f, 1e-45f, 0.1f, 7, 8, 9, -1, -2, 3e38f;
  model.coefficients = Eigen::Vector4d(0.1, 10.0 / 3, -1e-300, -1.0 / 3);
  return model;
}

template <typename Matrix>
Bytes raw(const Matrix& matrix) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(matrix.data());
  return {bytes, bytes + static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar)};
}

/// A file taken apart and put together again, without any of the code under test.
struct File {
  std::string header;
  Bytes data;

  static File split(const Bytes& bytes) {
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data(), 8);
    return {std::string(bytes.begin() + 8, bytes.begin() + 8 + static_cast<std::ptrdiff_t>(length)),
            Bytes(bytes.begin() + 8 + static_cast<std::ptrdiff_t>(length), bytes.end())};
  }
  Bytes join() const {
    const std::uint64_t length = header.size();
    Bytes bytes(8);
    std::memcpy(bytes.data(), &length, 8);
    bytes.insert(bytes.end(), header.begin(), header.end());
    bytes.insert(bytes.end(), data.begin(), data.end());
    return bytes;
  }
  void replace(const std::string& from, const std::string& to) {
    const std::size_t at = header.find(from);
    ASSERT_NE(at, std::string::npos) << from << " in " << header;
    ASSERT_EQ(header.find(from, at + 1), std::string::npos) << from << " stands twice";
    header.replace(at, from.size(), to);
  }
  nlohmann::json json() const { return nlohmann::json::parse(header); }
  void set(const nlohmann::json& json) { header = json.dump(); }
};

GraspModel read(const Bytes& bytes) {
  // A buffer of its own of exactly this size, so that a sanitizer sees one byte too many.
  const auto copy = std::make_unique<std::uint8_t[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), copy.get());
  return GraspModel::from_safetensors(copy.get(), bytes.size());
}

TEST(ModelFile, RoundTripKeepsEveryBit) {
  const GraspModel model = handmade_model();
  const Bytes bytes = model.to_safetensors();
  EXPECT_EQ(model.to_safetensors(), bytes);
  const GraspModel again = read(bytes);
  EXPECT_EQ(again.name, model.name);
  EXPECT_EQ(again.classes, model.classes);
  EXPECT_EQ(again.provenance, model.provenance);
  const DescriptorOptions &a = again.descriptor, &b = model.descriptor;
  EXPECT_EQ(a.fovea.object_px, b.fovea.object_px);
  EXPECT_EQ(a.fovea.margin_px, b.fovea.margin_px);
  EXPECT_EQ(a.contour.canny_low, b.contour.canny_low);
  EXPECT_EQ(a.contour.canny_high, b.contour.canny_high);
  EXPECT_EQ(a.contour.samples, b.contour.samples);
  EXPECT_EQ(a.contour.mask_margin_px, b.contour.mask_margin_px);
  EXPECT_EQ(a.shape_context.angular_bins, b.shape_context.angular_bins);
  EXPECT_EQ(a.shape_context.radial_bins, b.shape_context.radial_bins);
  EXPECT_EQ(a.shape_context.inner_radius, b.shape_context.inner_radius);
  EXPECT_EQ(a.shape_context.outer_radius, b.shape_context.outer_radius);
  EXPECT_EQ(a.shape_context.relative_to_gradient, b.shape_context.relative_to_gradient);
  EXPECT_EQ(a.patch.patch_px, b.patch.patch_px);
  EXPECT_EQ(a.patch.windows_patches, b.patch.windows_patches);
  EXPECT_EQ(raw(again.mean), raw(model.mean));
  EXPECT_EQ(raw(again.scale), raw(model.scale));
  EXPECT_EQ(raw(again.support_vectors), raw(model.support_vectors));
  EXPECT_EQ(raw(again.coefficients), raw(model.coefficients));
  EXPECT_EQ(again.svm_c, model.svm_c);
  EXPECT_EQ(again.gamma, model.gamma);
  EXPECT_EQ(again.rho, model.rho);
  EXPECT_EQ(again.sigmoid_a, model.sigmoid_a);
  EXPECT_EQ(again.sigmoid_b, model.sigmoid_b);
  EXPECT_EQ(again.to_safetensors(), bytes);

  GraspModel bare = model;  // what may be left empty
  bare.name.clear();
  bare.classes.clear();
  bare.provenance.clear();
  EXPECT_EQ(read(bare.to_safetensors()).to_safetensors(), bare.to_safetensors());
}

TEST(ModelFile, OnlyModelsThatTellTheOutlineSaySo) {
  const std::string entry = "descriptor.shape_context.outline_px";
  GraspModel model = handmade_model();
  const Bytes plain = model.to_safetensors();
  EXPECT_EQ(std::string(plain.begin(), plain.end()).find(entry), std::string::npos);
  EXPECT_EQ(read(plain).descriptor.shape_context.outline_px, 0);  // as in files of before that option

  model.descriptor.shape_context.outline_px = 4;
  EXPECT_THROW(model.to_safetensors(), InvalidInput);  // now it would have twice as many dimensions
  model.mean = Eigen::VectorXf::Zero(6);
  model.scale = Eigen::VectorXf::Ones(6);
  model.support_vectors = FeatureMatrix::Ones(4, 6);
  const Bytes twice = model.to_safetensors();
  const GraspModel again = read(twice);
  EXPECT_EQ(again.descriptor.shape_context.outline_px, 4);
  EXPECT_EQ(again.to_safetensors(), twice);
}

TEST(ModelFile, TrainedModelPredictsTheSameAfterwards) {
  const testing::Rows rows = testing::make_rows(10, 60, 120, 1);
  const GraspModel model = train_model(rows.features, rows.labels, rows.groups, testing::fixed_options());
  const GraspModel again = read(model.to_safetensors());
  EXPECT_EQ(again.predict_probability(rows.features), model.predict_probability(rows.features));
}

TEST(ModelFile, IsPlainSafetensors) {
  // Read by the format's description alone: header, offsets, little-endian numbers.
  const GraspModel model = handmade_model();
  const Bytes bytes = model.to_safetensors();
  const File file = File::split(bytes);
  EXPECT_EQ(file.header.front(), '{');
  EXPECT_EQ((8 + file.header.size()) % 8, 0u);  // aligned
  const nlohmann::json header = file.json();
  for (const auto& [key, value] : header["__metadata__"].items()) EXPECT_TRUE(value.is_string()) << key;
  const auto tensor = [&](const char* name) {
    const auto offsets = header[name]["data_offsets"].get<std::vector<std::size_t>>();
    const std::size_t number = header[name]["dtype"] == "F64" ? 8 : 4;
    EXPECT_EQ(offsets.at(0) % number, 0u) << name;
    return Bytes(file.data.begin() + static_cast<std::ptrdiff_t>(offsets.at(0)),
                 file.data.begin() + static_cast<std::ptrdiff_t>(offsets.at(1)));
  };
  EXPECT_EQ(tensor("mean"), raw(model.mean));
  EXPECT_EQ(tensor("scale"), raw(model.scale));
  EXPECT_EQ(tensor("support_vectors"), raw(model.support_vectors));
  EXPECT_EQ(tensor("coefficients"), raw(model.coefficients));
  EXPECT_EQ(header["support_vectors"]["shape"], nlohmann::json({4, 3}));
  EXPECT_EQ(header["support_vectors"]["dtype"], "F32");
  EXPECT_EQ(header["coefficients"]["dtype"], "F64");
  EXPECT_EQ(header["__metadata__"]["svm.gamma"], "3.3333333333333334e-08");
  // Another writer's order of keys and white space is as good.
  File other = file;
  other.header = header.dump(3);
  EXPECT_EQ(read(other.join()).to_safetensors(), bytes);
}

// -------------------------------------------------------------------------------------------- hostile files

/// A file that must be refused, and what the message has to name.
struct Hostile {
  const char* what;
  std::function<void(File&)> spoil;
  const char* message;
};

void edit(File& file, const std::function<void(nlohmann::json&)>& change) {
  nlohmann::json json = file.json();
  change(json);
  file.set(json);
}

std::function<void(File&)> metadata(const char* key, const char* value) {
  return [=](File& file) { edit(file, [&](nlohmann::json& json) { json["__metadata__"][key] = value; }); };
}

std::function<void(File&)> entry(const char* name, const char* key, const char* value) {
  return [=](File& file) {
    edit(file, [&](nlohmann::json& json) { json[name][key] = nlohmann::json::parse(value); });
  };
}

/// Sets one number of a tensor.
template <typename Number>
std::function<void(File&)> number(const char* name, std::size_t index, Number value) {
  return [=](File& file) {
    const std::size_t at = file.json()[name]["data_offsets"][0].get<std::size_t>() + index * sizeof value;
    ASSERT_LE(at + sizeof value, file.data.size());
    std::memcpy(file.data.data() + at, &value, sizeof value);
  };
}

std::string nested(int depth) {
  std::string text;
  for (int i = 0; i < depth; ++i) text += "{\"shape\":";
  return text;
}

const std::vector<Hostile>& hostile_files() {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float inf = std::numeric_limits<float>::infinity();
  static const std::vector<Hostile> files = {
      // The container.
      {"empty header", [](File& f) { f.header = ""; }, "must be a JSON object"},
      {"header is a list", [](File& f) { f.header = "[1, 2]"; }, "must be a JSON object"},
      {"header is no JSON", [](File& f) { f.header = "{\"a\": tru"; }, "not valid JSON"},
      {"header unfinished", [](File& f) { f.header.resize(f.header.size() / 2); }, "not valid JSON"},
      {"rubbish after the header", [](File& f) { f.header += "}"; }, "not valid JSON"},
      {"NUL in the header", [](File& f) { f.header[40] = '\0'; }, "not valid JSON"},
      {"invalid UTF-8", [](File& f) { f.replace("tea cup", "tea \xff\xfe"); }, "not valid JSON"},
      {"lone surrogate", [](File& f) { f.replace("tea cup", "\\ud800"); }, "not valid JSON"},
      {"deep objects", [](File& f) { f.header = nested(100000); }, "nests"},
      {"deep lists", [](File& f) { f.header = "{\"a\":" + std::string(200000, '['); }, "a list"},
      {"deep shape", [](File& f) { f.replace("[4,3]", std::string(100000, '[')); }, "a list"},
      {"deep metadata", [](File& f) { f.header = "{\"__metadata__\":" + nested(50000); }, "nests"},
      {"object in the metadata", [](File& f) { f.replace("\"tea cup\"", "{\"x\":\"y\"}"); }, "nests"},
      {"number in the metadata", [](File& f) { f.replace("\"tea cup\"", "7"); }, "a number"},
      {"null in the metadata", [](File& f) { f.replace("\"tea cup\"", "null"); }, "null"},
      {"metadata are text", [](File& f) { f.header = "{\"__metadata__\": \"x\"}"; }, "text"},
      {"metadata missing", [](File& f) { edit(f, [](nlohmann::json& j) { j.erase("__metadata__"); }); },
       "lack 'format'"},
      {"metadata twice", [](File& f) { f.header = "{\"__metadata__\":{}," + f.header.substr(1); },
       "'__metadata__' twice"},
      {"tensor twice", [](File& f) { f.replace("\"mean\"", "\"scale\""); }, "'scale' twice"},
      {"metadata key twice", [](File& f) { f.replace("\"svm.c\"", "\"svm.rho\""); }, "'svm.rho' twice"},
      {"dtype twice", [](File& f) { f.replace("\"F64\",\"shape\"", "\"F64\",\"dtype\":\"F64\",\"shape\""); },
       "twice"},
      {"empty shape twice", [](File& f) { f.replace("\"shape\":[4,3]", "\"shape\":[],\"shape\":[4,3]"); },
       "twice"},
      {"huge header", [](File& f) { f.header += std::string(std::size_t{2} << 20, ' '); }, "longer than"},
      {"thousands of tensors",
       [](File& f) {
         edit(f, [](nlohmann::json& j) {
           for (int i = 0; i < 5000; ++i) j["t" + std::to_string(i)] = j["mean"];
         });
       },
       "more than 64"},
      {"shape of many dimensions", entry("mean", "shape", "[1,1,1,1,1,1,1,1,1,3]"), "more than 8"},
      {"unknown field", entry("mean", "stride", "[1]"), "'stride' is unknown"},
      {"field missing", [](File& f) { edit(f, [](nlohmann::json& j) { j["mean"].erase("shape"); }); },
       "lacks its dtype"},
      {"tensor is a list", [](File& f) { f.header = "{\"mean\": [1]}"; }, "a list"},
      {"tensor is a number", [](File& f) { f.header = "{\"mean\": 1}"; }, "a number"},
      {"dtype unknown", entry("mean", "dtype", "\"I16\""), "'I16': expected F64, F32"},
      {"dtype a number", entry("mean", "dtype", "4"), "a number"},
      {"shape negative", entry("mean", "shape", "[-3]"), "negative"},
      {"shape fractional", entry("mean", "shape", "[3.0]"), "fractional"},
      {"shape beyond 64 bits", entry("mean", "shape", "[1e30]"), "huge number"},
      {"shape as text", entry("mean", "shape", "[\"3\"]"), "text"},
      {"shape overflows to the right size",  // 4 bytes · (2^62 + 4) · 3 = 3 · 2^64 + 48
       entry("support_vectors", "shape", "[4611686018427387908,3]"), "overflows"},
      {"shape overflows to zero", entry("support_vectors", "shape", "[4294967296,4294967296]"), "overflows"},
      {"shape too large", entry("support_vectors", "shape", "[5,3]"), "takes 60"},
      {"shape too small", entry("support_vectors", "shape", "[3,3]"), "takes 36"},
      {"one offset", entry("mean", "data_offsets", "[32]"), "needs two"},
      {"three offsets", entry("mean", "data_offsets", "[32,44,44]"), "needs two"},
      {"offsets backwards", entry("mean", "data_offsets", "[44,32]"), "lies at bytes 44 to 32"},
      {"offsets beyond the end", entry("mean", "data_offsets", "[1000000,1000012]"), "lies at bytes"},
      {"offsets overflow", entry("mean", "data_offsets", "[18446744073709551612,18446744073709551615]"),
       "lies at bytes"},
      {"offsets negative", entry("mean", "data_offsets", "[-12,0]"), "negative"},
      {"tensors overlap", entry("mean", "data_offsets", "[44,56]"), "overlap or leave a gap"},
      {"all tensors the same bytes",
       [](File& f) {
         edit(f, [](nlohmann::json& j) {
           j["mean"]["data_offsets"] = {0, 12};
           j["scale"]["data_offsets"] = {0, 12};
         });
       },
       "overlap or leave a gap"},
      {"bytes left over", [](File& f) { f.data.push_back(0); }, "cover"},
      {"a gap in front",
       [](File& f) {
         f.data.insert(f.data.begin(), 8, 0);
         edit(f, [](nlohmann::json& j) {
           for (const char* name : {"mean", "scale", "support_vectors", "coefficients"}) {
             for (auto& offset : j[name]["data_offsets"]) offset = offset.get<int>() + 8;
           }
         });
       },
       "leave a gap at byte 0"},
      {"data one byte short", [](File& f) { f.data.pop_back(); }, "lies at bytes"},
      {"no data", [](File& f) { f.data.clear(); }, "lies at bytes"},
      {"no tensors",
       [](File& f) {
         f.data.clear();
         edit(f, [](nlohmann::json& j) { j = {{"__metadata__", j["__metadata__"]}}; });
       },
       "'mean' is missing"},
      // The model in it.
      {"another format", metadata("format", "pt"), "expected the format"},
      {"another version", metadata("format_version", "2"), "version 2 is unknown"},
      {"version is no number", metadata("format_version", "1x"), "'1x': expected a whole number"},
      {"tensor renamed", [](File& f) { f.replace("\"mean\"", "\"average\""); }, "'mean' is missing"},
      {"tensor unknown",
       [](File& f) {
         edit(f, [](nlohmann::json& j) {
           j["x"] = {{"dtype", "F32"}, {"shape", {0}}, {"data_offsets", {0, 0}}};
         });
       },
       "unknown tensor"},
      {"no vectors at all",
       [](File& f) {
         f.data.assign(24, 0);
         edit(f, [](nlohmann::json& j) {
           j["mean"]["data_offsets"] = {0, 12};
           j["scale"]["data_offsets"] = {12, 24};
           j["support_vectors"] = {{"dtype", "F32"}, {"shape", {0, 3}}, {"data_offsets", {24, 24}}};
           j["coefficients"] = {{"dtype", "F64"}, {"shape", {0}}, {"data_offsets", {24, 24}}};
         });
       },
       "dimension of 0"},
      {"vectors without columns",
       [](File& f) {
         edit(f, [](nlohmann::json& j) {
           j["support_vectors"] = {
               {"dtype", "F32"}, {"shape", {1000000000000u, 0}}, {"data_offsets", {56, 56}}};
         });
         f.data.resize(56);
       },
       "dimension of 1000000000000"},
      {"vectors turned", entry("support_vectors", "shape", "[3,4]"), "the support vectors 4"},
      {"vectors in one row", entry("support_vectors", "shape", "[12]"), "of 2 dimensions"},
      {"mean as a matrix", entry("mean", "shape", "[3,1]"), "of 1 dimensions"},
      {"coefficients as F32",
       [](File& f) {
         edit(f, [](nlohmann::json& j) {
           j["coefficients"]["dtype"] = "F32";
           j["coefficients"]["shape"] = {8};
         });
       },
       "F64"},
      {"mean NaN", number("mean", 1, nan), "mean must be finite"},
      {"scale infinite", number("scale", 1, inf), "scale must be finite and positive"},
      {"scale zero", number("scale", 2, 0.0f), "scale must be finite and positive"},
      {"scale negative", number("scale", 2, -1.0f), "scale must be finite and positive"},
      {"vector NaN", number("support_vectors", 11, nan), "support vectors must be finite"},
      {"vector infinite", number("support_vectors", 0, -inf), "support vectors must be finite"},
      {"coefficient NaN", number("coefficients", 0, std::numeric_limits<double>::quiet_NaN()),
       "coefficients"},
      {"coefficient zero", number("coefficients", 3, 0.0), "coefficients"},
      {"coefficient over C", number("coefficients", 0, 4.0), "coefficients"},
      {"classes mixed", number("coefficients", 0, -1.0), "positive class must come first"},
      {"C missing", [](File& f) { edit(f, [](nlohmann::json& j) { j["__metadata__"].erase("svm.c"); }); },
       "lack 'svm.c'"},
      {"C negative", metadata("svm.c", "-1"), "C must be positive"},
      {"C empty", metadata("svm.c", ""), "expected a finite number"},
      {"gamma NaN", metadata("svm.gamma", "nan"), "expected a finite number"},
      {"gamma beyond double", metadata("svm.gamma", "1e999"), "expected a finite number"},
      {"gamma zero", metadata("svm.gamma", "0"), "gamma must be positive"},
      {"gamma with a comma", metadata("svm.gamma", "0,5"), "expected a finite number"},
      {"gamma in hexadecimal", metadata("svm.gamma", "0x1p-3"), "expected a finite number"},
      {"gamma with a blank", metadata("svm.gamma", " 0.5"), "expected a finite number"},
      {"gamma with a tail", metadata("svm.gamma", "0.5 "), "expected a finite number"},
      {"rho infinite", metadata("svm.rho", "inf"), "expected a finite number"},
      {"rho huge", metadata("svm.rho", "1e300"), "rho must be"},
      {"sigmoid NaN", metadata("sigmoid.a", "-nan"), "expected a finite number"},
      {"sigmoid huge", metadata("sigmoid.b", "1e200"), "sigmoid"},
      {"bins overflow", metadata("descriptor.shape_context.angular_bins", "2147483647"), "at most a million"},
      {"bins beyond int", metadata("descriptor.shape_context.radial_bins", "4294967297"), "a whole number"},
      {"bins zero", metadata("descriptor.shape_context.radial_bins", "0"), "radial_bins"},
      {"bins of another model", metadata("descriptor.shape_context.radial_bins", "2"), "6 dimensions"},
      {"patch of no size", metadata("descriptor.patch.patch_px", "0"), "patch_px"},
      {"patch fractional", metadata("descriptor.patch.patch_px", "10.5"), "a whole number"},
      {"window even", metadata("descriptor.patch.windows_patches.1", "4"), "windows_patches"},
      {"samples a million and one", metadata("descriptor.contour.samples", "1000001"), "at most a million"},
      {"Canny infinite", metadata("descriptor.contour.canny_high", "inf"), "expected a finite number"},
      {"radii swapped", metadata("descriptor.shape_context.inner_radius", "3"), "radius"},
      {"neither true nor false", metadata("descriptor.shape_context.relative_to_gradient", "1"),
       "true or false"},
      {"an entry too many", metadata("svm.kernel", "linear"), "unknown entry 'svm.kernel'"},
      {"a class missing",
       [](File& f) { edit(f, [](nlohmann::json& j) { j["__metadata__"].erase("class.5"); }); },
       "numbered from 0"},
      {"a class of another number", metadata("class.007", "bond"), "numbered from 0"},
      {"a class without a name", metadata("class.0", ""), "class names"},
      {"control characters", metadata("name", "mug\x1b[2J"), "control characters"},
  };
  return files;
}

TEST(ModelFile, HostileFilesAreRefusedByName) {
  const Bytes good = handmade_model().to_safetensors();
  for (const Hostile& hostile : hostile_files()) {
    File file = File::split(good);
    hostile.spoil(file);
    if (::testing::Test::HasFatalFailure()) return;
    try {
      read(file.join());
      ADD_FAILURE() << hostile.what << ": it was accepted";
    } catch (const InvalidInput& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(hostile.message), std::string::npos) << hostile.what << ": " << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << hostile.what;
      EXPECT_LT(message.size(), 400u) << hostile.what;
    }
  }
  EXPECT_GE(hostile_files().size(), 30u);
}

TEST(ModelFile, HeaderLengthsAreNotTrusted) {
  const Bytes good = handmade_model().to_safetensors();
  const std::uint64_t right = File::split(good).header.size();
  for (const std::uint64_t length :
       {std::uint64_t{0}, right - 1, right + 1, right + 8, std::uint64_t{good.size()},
        std::uint64_t{good.size() - 7}, std::uint64_t{1} << 20, std::uint64_t{1} << 32,
        std::uint64_t{1} << 63, ~std::uint64_t{0}, ~std::uint64_t{0} - 7}) {
    Bytes bytes = good;
    std::memcpy(bytes.data(), &length, 8);
    EXPECT_THROW(read(bytes), InvalidInput) << length;
  }
  EXPECT_THROW(GraspModel::from_safetensors(nullptr, 0), InvalidInput);
}

TEST(ModelFile, TruncatedAnywhereItIsRefused) {
  const Bytes good = handmade_model().to_safetensors();
  for (std::size_t size = 0; size < good.size(); ++size) {
    const Bytes bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(read(bytes), InvalidInput) << size;
  }
}

TEST(ModelFile, RandomDamageIsRefusedOrHarmless) {
  const GraspModel model = handmade_model();
  const Bytes good = model.to_safetensors();
  const std::size_t header_end = 8 + File::split(good).header.size();
  const FeatureMatrix features = FeatureMatrix::Random(3, 3);
  std::mt19937 generator(1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(uniform(generator) * n); };
  int loaded = 0, refused = 0;
  for (int round = 0; round < 6000; ++round) {
    Bytes bytes = good;
    const std::size_t times = 1 + below(4);
    for (std::size_t i = 0; i < times; ++i) {
      // Mostly in the header, where the structure is; sometimes in the numbers or in the length.
      const double where = uniform(generator);
      const std::size_t at = where < 0.7   ? 8 + below(header_end - 8)
                             : where < 0.9 ? header_end + below(bytes.size() - header_end)
                                           : below(bytes.size());
      if (at >= bytes.size()) continue;
      const auto position = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      const std::string likely = "0123456789-+.eE\"{}[],:\\ \t";
      switch (below(5)) {
        case 0:
          *position ^= static_cast<std::uint8_t>(1u << below(8));
          break;
        case 1:
          *position = static_cast<std::uint8_t>(generator());
          break;
        case 2:
          *position = static_cast<std::uint8_t>(likely[below(likely.size())]);
          break;
        case 3:
          bytes.erase(position);
          break;
        default:
          bytes.insert(position, static_cast<std::uint8_t>(likely[below(likely.size())]));
      }
    }
    if (below(2) == 0) {  // make the length fit again, so that the damage reaches further in
      const auto grown = static_cast<std::ptrdiff_t>(bytes.size()) - static_cast<std::ptrdiff_t>(good.size());
      const std::uint64_t length = header_end - 8 + static_cast<std::uint64_t>(grown);
      std::memcpy(bytes.data(), &length, 8);
    }
    try {
      const GraspModel damaged = read(bytes);
      damaged.check();
      ++loaded;
      if (damaged.mean.size() == 3) {
        const Eigen::VectorXd p = damaged.predict_probability(features);
        EXPECT_TRUE((p.array() >= 0).all() && (p.array() <= 1).all()) << "round " << round;
      }
      EXPECT_EQ(read(damaged.to_safetensors()).to_safetensors(), damaged.to_safetensors());
    } catch (const InvalidInput&) {
      ++refused;
    }
  }
  std::printf("  damaged files: %d refused, %d loaded as another valid model\n", refused, loaded);
  EXPECT_GT(refused, 1000);
  EXPECT_GT(loaded, 100);  // otherwise the damage never got as far as the numbers
}

}  // namespace
}  // namespace graspctx
