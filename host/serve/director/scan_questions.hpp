// Questions about DICOM files, which processes of pxpl5-io answer while the session goes on.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace pxpl5::host::serve {

inline constexpr int scan_question_ms = 60'000;  ///< A process that takes longer is killed.

/// Answers one question at a time, in a thread of its own. A newer question ends the process of the
/// one before, which is answered with an error.
class ScanQuestions {
  public:
    struct Parts {
        /// Words before the question: the program pxpl5-io, limits and allowed folders.
        std::vector<std::string> words;
        /// Throws RequestError if the browser may not read the path. Called by ask().
        std::function<void(const std::string& path)> check;
        /// Send to a viewer. Called in the thread.
        std::function<void(std::uint32_t viewer, std::string text)> send;
        std::function<void(std::uint32_t viewer, std::string bytes)> send_binary;
    };

    explicit ScanQuestions(Parts parts);
    /// Ends the process under way.
    ~ScanQuestions();
    ScanQuestions(const ScanQuestions&) = delete;
    ScanQuestions& operator=(const ScanQuestions&) = delete;

    /// The open volume: its file or folder, and its series. Both are empty if none is open.
    struct OpenScan {
        std::string source, series;
    };

    /// Whether the `ask` message is a question of this class: {"ask":"series","path":..}, or
    /// {"ask":"attributes"} of the open volume. If so, the answer follows.
    /// Throws RequestError (usage) if there is no path, or one that may not be read.
    bool ask(std::uint32_t viewer, std::uint32_t id, std::string_view message,
             const OpenScan& open);

  private:
    void answer(std::uint32_t viewer, std::uint32_t id, const std::vector<std::string>& question);
    void stop();

    Parts parts_;
    int stop_fd_;  ///< Readable while the process under way shall end.
    std::thread thread_;
};

/// The answer to {"ask":"series"}: JSON and the pixels of the thumbnails.
struct SeriesAnswer {
    std::string json;
    std::string pixels;
};

/// Reads the lines that `pxpl5-io --series` has written, which may be cut anywhere.
///
/// note    Why the process has ended early; empty if it has not. Part of the answer.
/// Throws  RequestError (bad_data) if the list of series is missing or is none.
SeriesAnswer read_series_lines(const std::string& lines, const std::string& note);

}  // namespace pxpl5::host::serve
