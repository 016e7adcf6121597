#include <gtest/gtest.h>
#include <sys/stat.h>

#include <thread>

#include "graspctx/error.hpp"
#include "graspctx/io/atomic_file.hpp"
#include "temporary_folder.hpp"

namespace graspctx {
namespace {

using testing::message_of;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

TEST(AtomicFile, ReplacesTheContentAndLeavesNothingElse) {
  const TemporaryFolder folder;
  folder.put("out", "a longer text than the next one");
  write_file_atomically(folder / "out", std::string("new\0text", 8));
  EXPECT_EQ(folder.get("out"), std::string("new\0text", 8));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, KeepsWhatStoodThereWhenOneOfSeveralFails) {
  const TemporaryFolder folder;
  folder.put("first", "old");
  fs::create_directory(folder / "second");
  const std::string message = message_of<InvalidInput>([&] {
    write_files_atomically({{folder / "first", "new"}, {folder / "second", "new"}});
  });
  EXPECT_NE(message.find((folder / "second").string()), std::string::npos) << message;
  EXPECT_EQ(folder.get("first"), "old");
  EXPECT_EQ(folder.entries(), 2u);
}

TEST(AtomicFile, KeepsWhatStoodThereWhenTheDiskIsFull) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const TemporaryFolder folder;
  folder.put("first", "old");
  EXPECT_THROW(write_files_atomically({{folder / "first", "new"}, {"/dev/full", "new"}}), InvalidInput);
  EXPECT_EQ(folder.get("first"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, RefusesAMissingFolderAndAFolderAsFile) {
  const TemporaryFolder folder;
  EXPECT_THROW(check_writable(folder / "no/out"), InvalidInput);
  EXPECT_THROW(check_writable(folder.path()), InvalidInput);
  EXPECT_THROW(check_writable(""), InvalidInput);
  EXPECT_NO_THROW(check_writable(folder / "out"));
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(AtomicFile, FollowsSymbolicLinksAndKeepsPermissions) {
  const TemporaryFolder folder;
  folder.put("target", "old");
  ::chmod((folder / "target").c_str(), 0640);
  fs::create_symlink("target", folder / "link");
  write_file_atomically(folder / "link", std::string("new"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(folder.get("target"), "new");
  EXPECT_EQ(static_cast<unsigned>(fs::status(folder / "target").permissions()), 0640u);
}

TEST(AtomicFile, WritesToADeviceWithoutReplacingIt) {
  write_file_atomically("/dev/null", std::string("text"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(AtomicFile, ReadersNeverSeeHalfAFile) {
  const TemporaryFolder folder;
  const std::string a(200000, 'a'), b(100000, 'b');
  write_file_atomically(folder / "out", a);
  std::thread writer([&] {
    for (int i = 0; i < 50; ++i) write_file_atomically(folder / "out", i % 2 ? a : b);
  });
  for (int i = 0; i < 200; ++i) {
    const std::string seen = folder.get("out");
    EXPECT_TRUE(seen == a || seen == b) << "read " << seen.size() << " bytes";
  }
  writer.join();
}

TEST(ReadFile, NamesTheFileThatCannotBeRead) {
  const TemporaryFolder folder;
  folder.put("large", std::string(11, 'x'));
  for (const auto& [name, what] :
       {std::pair{"missing", "no such file"}, {"large", "too large"}, {"", "folder"}}) {
    const fs::path file = *name ? folder / name : folder.path();
    const std::string message = message_of<InvalidInput>([&, &file = file] { read_file(file, 10); });
    EXPECT_NE(message.find(file.string()), std::string::npos) << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
  }
  EXPECT_EQ(read_file(folder / "large", 11).size(), 11u);
}

}  // namespace
}  // namespace graspctx
