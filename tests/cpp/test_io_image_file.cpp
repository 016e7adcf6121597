#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "graspctx/error.hpp"
#include "graspctx/io/image_file.hpp"
#include "synthetic.hpp"
#include "temporary_folder.hpp"

namespace graspctx {
namespace {

using testing::message_of;
using testing::random_texture;
using testing::TemporaryFolder;

cv::Mat grey(const cv::Mat& colour) {
  cv::Mat result;
  cv::cvtColor(colour, result, cv::COLOR_BGR2GRAY);
  return result;
}

double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

TEST(ImageFile, PngKeepsEveryPixel) {
  const TemporaryFolder folder;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(7, 3), cv::Size(64, 48)}) {
    const cv::Mat colour = random_texture(size, 5);
    write_image(folder / "colour.png", colour);
    write_image(folder / "grey.PNG", grey(colour));
    const cv::Mat colour_read = read_image(folder / "colour.png"),
                  grey_read = read_image(folder / "grey.PNG");
    ASSERT_EQ(colour_read.type(), CV_8UC3);
    ASSERT_EQ(grey_read.type(), CV_8UC1);
    EXPECT_EQ(largest_difference(colour_read, colour), 0);
    EXPECT_EQ(largest_difference(grey_read, grey(colour)), 0);
  }
}

TEST(ImageFile, JpegKeepsColoursInOrder) {
  const TemporaryFolder folder;
  const cv::Mat image(40, 50, CV_8UC3, cv::Scalar(200, 60, 20));
  write_image(folder / "image.jpg", image);
  write_image(folder / "grey.jpeg", grey(image));
  EXPECT_LE(largest_difference(read_image(folder / "image.jpg"), image), 3);
  EXPECT_EQ(read_image(folder / "grey.jpeg").type(), CV_8UC1);
}

TEST(ImageFile, WritesPartOfAnImage) {
  const TemporaryFolder folder;
  const cv::Mat image = random_texture({40, 30}, 1)(cv::Rect(3, 5, 21, 11));
  write_image(folder / "part.png", image);
  EXPECT_EQ(largest_difference(read_image(folder / "part.png"), image), 0);
}

TEST(ImageFile, EveryTruncationIsFound) {
  const TemporaryFolder folder;
  const cv::Mat image = random_texture({13, 9}, 3);
  for (const std::string name : {"image.png", "image.jpg"}) {
    write_image(folder / name, image);
    const std::string bytes = folder.get(name);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      folder.put(name, bytes.substr(0, size));
      const std::string message = message_of<InvalidInput>([&] { read_image(folder / name); });
      ASSERT_NE(message.find(name), std::string::npos)
          << size << " of " << bytes.size() << " bytes of " << name;
    }
  }
}

TEST(ImageFile, EveryDamagedByteOfAPngIsFound) {
  const TemporaryFolder folder;
  const cv::Mat image = grey(random_texture({13, 9}, 3));
  write_image(folder / "image.png", image);
  const std::string bytes = folder.get("image.png");
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    folder.put("image.png", damaged);
    EXPECT_THROW(read_image(folder / "image.png"), InvalidInput) << "byte " << at << " of " << bytes.size();
    EXPECT_THROW(read_mask(folder / "image.png"), InvalidInput) << "byte " << at << " of " << bytes.size();
  }
}

TEST(ImageFile, DamagedJpegsNeverCrash) {
  const TemporaryFolder folder;
  write_image(folder / "image.jpg", random_texture({13, 9}, 3));
  const std::string bytes = folder.get("image.jpg");
  int refused = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    folder.put("image.jpg", damaged);
    try {
      EXPECT_FALSE(read_image(folder / "image.jpg").empty());
    } catch (const InvalidInput&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 50);  // a JPEG has no checksum: most, not all, can be found
}

TEST(ImageFile, PrintsNothing) {
  const TemporaryFolder folder;
  const cv::Mat image = random_texture({13, 9}, 3);
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  for (const std::string name : {"image.png", "image.jpg"}) {
    write_image(folder / name, image);
    const std::string bytes = folder.get(name);
    folder.put(name, bytes.substr(0, bytes.size() / 2));
    EXPECT_THROW(read_image(folder / name), InvalidInput);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

TEST(ImageFile, RefusesWhatIsNoImage) {
  const TemporaryFolder folder;
  folder.put("text.png", "this is no picture\n");
  folder.put("empty.png", "");
  for (const std::string name : {"text.png", "empty.png", "missing.png"}) {
    const std::string message = message_of<InvalidInput>([&] { read_image(folder / name); });
    EXPECT_NE(message.find((folder / name).string()), std::string::npos) << message;
  }
  EXPECT_THROW(read_image(folder.path()), InvalidInput);
  EXPECT_THROW(write_image(folder / "image.tiff", cv::Mat::zeros(2, 2, CV_8UC1)), InvalidInput);
  EXPECT_THROW(write_image(folder / "image.png", cv::Mat::zeros(2, 2, CV_32FC1)), InvalidInput);
  EXPECT_THROW(write_image(folder / "image.png", cv::Mat()), InvalidInput);
}

TEST(ImageFile, RefusesOversizedDimensionsWithoutAllocating) {
  const TemporaryFolder folder;
  // A header that says 65535x65535 and no data; the checksum is right.
  const std::string header(
      "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff\xff\x08\x02\0\0\0\x96\xd2\xe4\x8a", 33);
  folder.put("huge.png", header);
  const std::string message = message_of<InvalidInput>([&] { read_image(folder / "huge.png"); });
  EXPECT_NE(message.find("huge.png"), std::string::npos) << message;
}

TEST(MaskFile, KeepsInstanceIdsAndRefusesOtherKinds) {
  const TemporaryFolder folder;
  cv::Mat ids(5, 256, CV_8UC1);
  for (int u = 0; u < 256; ++u) ids.col(u) = cv::Scalar(u);
  write_image(folder / "ids.png", ids);
  EXPECT_EQ(largest_difference(read_mask(folder / "ids.png"), ids), 0);

  write_image(folder / "colour.png", random_texture({8, 8}, 1));
  write_image(folder / "grey.jpg", ids);
  for (const std::string name : {"colour.png", "grey.jpg", "missing.png"}) {
    const std::string message = message_of<InvalidInput>([&] { read_mask(folder / name); });
    EXPECT_NE(message.find(name), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace graspctx
