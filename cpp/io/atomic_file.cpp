#include "graspctx/io/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>

#include "graspctx/error.hpp"

namespace graspctx {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InvalidInput(file.string() + ": " + what);
}

std::string system_message(int error) {
  return std::generic_category().message(error);
}

/// A file descriptor that is closed whatever happens.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  /// Some file systems report a failed write only here. Returns 0 or the error.
  int close() {
    const int result = ::close(number_);
    number_ = -1;
    return result == 0 ? 0 : errno;
  }

 private:
  int number_;
};

void write_all(const Descriptor& descriptor, const char* bytes, std::size_t size, const fs::path& file) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor.get(), bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(file, "cannot be written: " + system_message(errno));
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
}

/// Where the bytes go: the file itself, or what a symbolic link points to.
fs::path resolve(const fs::path& file) {
  std::error_code error;
  if (!fs::is_symlink(file, error)) return file;
  const fs::path target = fs::weakly_canonical(file, error);
  return error ? file : target;
}

bool is_special(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// A new file beside `target`; removed again unless it is committed.
class TemporaryFile {
 public:
  TemporaryFile(const fs::path& file, const std::string& bytes) : file_(file), target_(resolve(file)) {
    static std::atomic<unsigned> counter{0};
    int number = -1;
    do {  // O_EXCL: never another process's file; mode 0666: the user's umask decides, as for any output
      temporary_ = target_;
      temporary_ += ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
      number = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (number < 0 && errno == EEXIST);
    if (number < 0) fail(file_, "cannot be written: " + system_message(errno));
    Descriptor descriptor(number);
    try {
      struct stat existing {};
      if (::stat(target_.c_str(), &existing) == 0) {
        // Best effort: the new content keeps the old file's permissions.
        [[maybe_unused]] const int ignored = ::fchmod(descriptor.get(), existing.st_mode & 07777);
      }
      write_all(descriptor, bytes.data(), bytes.size(), file_);
      if (::fsync(descriptor.get()) != 0 && errno != EINVAL) {
        fail(file_, "cannot be written: " + system_message(errno));
      }
      if (const int error = descriptor.close()) fail(file_, "cannot be written: " + system_message(error));
    } catch (...) {
      ::unlink(temporary_.c_str());
      throw;
    }
  }
  ~TemporaryFile() {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }
  TemporaryFile(TemporaryFile&& other) noexcept
      : file_(std::move(other.file_)), target_(std::move(other.target_)) {
    temporary_.swap(other.temporary_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  TemporaryFile& operator=(TemporaryFile&&) = delete;

  void commit() {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
      fail(file_, "cannot be written: " + system_message(errno));
    }
    temporary_.clear();
  }

 private:
  fs::path file_, target_, temporary_;
};

void write_special(const fs::path& file, const std::string& bytes) {
  Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (descriptor.get() < 0) fail(file, "cannot be written: " + system_message(errno));
  write_all(descriptor, bytes.data(), bytes.size(), file);
}

}  // namespace

void check_writable(const fs::path& file) {
  if (file.empty()) throw InvalidInput("output file: the name is empty");
  std::error_code error;
  if (fs::is_directory(file, error)) fail(file, "cannot be written: it is a folder, expected a file name");
  const fs::path target = resolve(file);
  if (fs::exists(target, error)) {
    if (::access(target.c_str(), W_OK) != 0) fail(file, "cannot be written: " + system_message(errno));
    if (is_special(target)) return;
  }
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    fail(file, "cannot be written: there is no folder " + folder.string());
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    fail(file, "cannot be written: the folder " + folder.string() + " is not writable");
  }
}

void write_files_atomically(const std::vector<PendingFile>& files) {
  for (const PendingFile& pending : files) check_writable(pending.file);
  std::vector<TemporaryFile> temporaries;
  temporaries.reserve(files.size());
  for (const PendingFile& pending : files) {
    if (!is_special(pending.file)) temporaries.emplace_back(pending.file, pending.bytes);
  }
  for (const PendingFile& pending : files) {
    if (is_special(pending.file)) write_special(pending.file, pending.bytes);
  }
  for (TemporaryFile& temporary : temporaries) temporary.commit();
}

void write_file_atomically(const fs::path& file, const void* bytes, std::size_t size) {
  write_files_atomically({{file, std::string(static_cast<const char*>(bytes), size)}});
}

void write_file_atomically(const fs::path& file, const std::string& text) {
  write_files_atomically({{file, text}});
}

std::vector<std::uint8_t> read_file(const fs::path& file, std::size_t max_bytes) {
  if (file.empty()) throw InvalidInput("input file: the name is empty");
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) fail(file, "no such file");
  if (fs::is_directory(status)) fail(file, "is a folder, expected a file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail(file, "cannot be opened: " + system_message(errno));
  std::vector<std::uint8_t> bytes;
  char block[1 << 16];
  // In blocks rather than by size: pipes have none.
  while (stream.read(block, sizeof block) || stream.gcount() > 0) {
    bytes.insert(bytes.end(), block, block + stream.gcount());
    if (bytes.size() > max_bytes) {
      fail(file, "is too large, expected at most " + std::to_string(max_bytes) + " bytes");
    }
  }
  if (stream.bad()) fail(file, "cannot be read");
  return bytes;
}

}  // namespace graspctx
