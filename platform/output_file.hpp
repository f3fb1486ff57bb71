// A file that is written front to back; a disk that is full is noticed, not passed over.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace polhode::platform {

class OutputFile {
 public:
  /// Creates or empties the file. @throws RunFailure naming it, here and in every call below.
  explicit OutputFile(const std::filesystem::path& file) : OutputFile(file, "wbe", file) {}

  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Writes out what is buffered and closes. Without it an error of the last bytes would go
  /// unnoticed.
  void close();

 private:
  friend void write_file(const std::filesystem::path& file, std::string_view text);
  /// @param named  in exceptions, instead of the file.
  OutputFile(const std::filesystem::path& file,
             const char* mode,
             const std::filesystem::path& named);

  [[noreturn]] void fail() const;

  struct Close {
    void operator()(std::FILE* stream) const { std::fclose(stream); }
  };
  std::string name_;
  std::unique_ptr<std::FILE, Close> stream_;
};

/// A name beside the file's that nobody has: what stands there is somebody's.
std::filesystem::path fresh_beside(const std::filesystem::path& file);

/// Writes a small file as a whole: beside it, then moved to its place, so that it is whole, or as
/// it was before. The old content is replaced, a symbolic link, too.
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace polhode::platform
