#include <gtest/gtest.h>

#include "../../cpp/io/detail/sha256.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/model_file.hpp"
#include "temporary_folder.hpp"

namespace graspctx {
namespace {

using testing::message_of;
using testing::TemporaryFolder;

std::string sha256(const std::string& text) {
  return detail::sha256_hex(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

/// A small valid model with numbers that are easy to recognise.
GraspModel small_model(const std::string& name) {
  GraspModel model;
  model.name = name;
  model.classes = {"mug"};
  model.provenance = {{"command", "graspctx_cli train"}};
  const int dimension = model.descriptor.dimension(), vectors = 3;
  model.mean = Eigen::VectorXf::Constant(dimension, 0.25f);
  model.scale = Eigen::VectorXf::Constant(dimension, 2);
  model.svm_c = 10;
  model.gamma = 0.01;
  model.support_vectors = FeatureMatrix::Zero(vectors, dimension);
  for (int i = 0; i < vectors; ++i) model.support_vectors(i, i) = 1;
  model.coefficients = Eigen::Vector3d(1, 0.5, -1.5);
  model.rho = 0.125;
  model.sigmoid_a = -2;
  model.sigmoid_b = 0.5;
  return model;
}

// FIPS 180-2, appendix B, and the NIST test vectors for short and long messages.
TEST(Sha256, NistVectors) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(
      sha256(
          "abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrs"
          "mnopqrstnopqrstu"),
      "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(sha256("\xbd"), "68325720aabd7c82f30f554b313d0570c95accbb7dc4b5aae11204c08ffe732b");
  EXPECT_EQ(sha256(std::string(55, '\0')),
            "02779466cdec163811d078815c633f21901413081449002f24aa3e80f0b88ef7");
  EXPECT_EQ(sha256(std::string(56, '\0')),
            "d4817aa5497628e7c77e6b606107042bbba3130888c5f47a375e6179be789fbb");
  EXPECT_EQ(sha256(std::string(64, '\0')),
            "f5a5fd42d16a20302798ef6ed309979b43003d2320d9f0e8ea9831a92759fb4b");
}

TEST(ModelFile, ReadsBackWhatItWrote) {
  const TemporaryFolder folder;
  const GraspModel model = small_model("tiny");
  save_model(model, folder / "tiny.safetensors");
  const LoadedModel loaded = load_model((folder / "tiny.safetensors").string());
  EXPECT_EQ(loaded.model.name, "tiny");
  EXPECT_EQ(loaded.model.coefficients, model.coefficients);
  EXPECT_EQ(loaded.sha256, sha256(folder.get("tiny.safetensors")));
}

TEST(ModelFile, FindsModelsByNameInTheFoldersInOrder) {
  const TemporaryFolder first, second;
  save_model(small_model("one"), first / "cup.safetensors");
  save_model(small_model("two"), second / "cup.safetensors");
  save_model(small_model("two"), second / "ladle.safetensors");
  second.put("notes.txt", "no model");
  EXPECT_EQ(load_model("cup", {first.path(), second.path()}).model.name, "one");
  EXPECT_EQ(load_model("cup", {second.path(), first.path()}).model.name, "two");
  EXPECT_EQ(load_model("ladle", {first.path(), second.path()}).model.name, "two");

  std::vector<std::string> names;
  for (const auto& file : shipped_models({first.path(), second.path()}))
    names.push_back(file.stem().string());
  EXPECT_EQ(std::count(names.begin(), names.end(), "cup"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "ladle"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "notes"), 0);
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));

  const std::string message = message_of<InvalidInput>([&] { load_model("spoon", {first.path()}); });
  EXPECT_NE(message.find("spoon"), std::string::npos) << message;
  EXPECT_NE(message.find("cup"), std::string::npos) << message;  // says what there is
}

TEST(ModelFile, EveryTruncationIsFoundAndNamesTheFile) {
  const TemporaryFolder folder;
  save_model(small_model("tiny"), folder / "tiny.safetensors");
  const std::string bytes = folder.get("tiny.safetensors");
  for (std::size_t size = 0; size < bytes.size(); size += 13) {
    folder.put("tiny.safetensors", bytes.substr(0, size));
    const std::string message =
        message_of<InvalidInput>([&] { load_model((folder / "tiny.safetensors").string()); });
    ASSERT_NE(message.find("tiny.safetensors"), std::string::npos) << size << ": " << message;
  }
}

}  // namespace
}  // namespace graspctx
