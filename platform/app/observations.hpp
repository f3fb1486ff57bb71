// The image measurements of a run: as a table, and spooled for the re-estimation at the end.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "output_file.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// observations.csv: frame,timestamp_ns,landmark,u_px,v_px,predicted_u_px,predicted_v_px,inlier
class ObservationTable {
 public:
  explicit ObservationTable(const std::filesystem::path& file);
  void append(std::size_t frame,
              std::int64_t timestamp_ns,
              std::span<const Observation> observations);
  void close() { out_.close(); }

 private:
  OutputFile out_;
  std::string text_;
};

/// A frame's observations kept on disk, so that memory does not grow with the length of a run
/// beyond an index entry a frame.
class ObservationSpool {
 public:
  ObservationSpool(const std::filesystem::path& file, std::size_t frames);
  ~ObservationSpool();
  ObservationSpool(const ObservationSpool&) = delete;
  ObservationSpool& operator=(const ObservationSpool&) = delete;

  /// The next frame's, in order of the frames.
  void append(std::span<const Observation> observations);

  /// @return the inlier observations of a frame; valid until the next call.
  std::span<const Observation> of_frame(std::size_t frame);

 private:
  struct Close {
    void operator()(std::FILE* stream) const { std::fclose(stream); }
  };
  [[noreturn]] void fail() const;

  std::filesystem::path file_;
  std::unique_ptr<std::FILE, Close> stream_;
  std::vector<std::uint64_t> ends_;  ///< of each frame's records, in records from the start
  std::vector<Observation> buffer_;
};

}  // namespace polhode::platform
