// The facts that a running program writes to its run folder, for `pxpl5 sessions`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace pxpl5::host {

/// Name of the file in the run folder.
inline constexpr const char* note_name = "session.json";

/// The facts that change while a program runs. The manifest has the others.
struct SessionFacts {
    std::string volume;  ///< File, folder or phantom:NAME; empty if none is open.
    std::string url = {},
                watch_url = {};  ///< Addresses of the page, with tokens. Empty without a page.
    std::string tunnel = {};     ///< The line for ssh that opens the way to the page.
    std::int64_t viewers = 0;    ///< Open pages.
    std::string ends_at = {};    ///< When something from outside ends it; empty if unknown.
    std::string saved = {};      ///< File of the session, once it is saved before the end.
    bool is_ending = false;
};

/// The file with the facts. It loses the addresses with this object, because they end, too.
class SessionNote {
  public:
    explicit SessionNote(const std::filesystem::path& run_folder);
    ~SessionNote();
    SessionNote(const SessionNote&) = delete;
    SessionNote& operator=(const SessionNote&) = delete;

    const SessionFacts& facts() const { return facts_; }
    /// Replaces the file, for the owner alone, if the facts differ. A file that cannot be written
    /// stays as it was: a full disk must not end a session.
    void set(const SessionFacts& facts);

  private:
    std::filesystem::path file_;
    SessionFacts facts_;
};

/// Reads the facts in a run folder. A missing or damaged fact is empty.
SessionFacts read_note(const std::filesystem::path& run_folder);

}  // namespace pxpl5::host
