// The commands of pxpl5 trace step: one line in, its answer out.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/inspect/map/region_picture.hpp"
#include "host/inspect/step/stepper.hpp"

namespace pxpl5::host::inspect {

class StepProgram {
  public:
    /// Stands at the begin of a frame. `run` outlives it. Throws as Stepper does.
    StepProgram(const RecordedRun& run, std::uint32_t frame, TerminalStyle style);

    /// Executes one command. Returns its answer, without the last line's end; empty for an empty
    /// line. Throws RequestError (usage) if it is none, or cannot be obeyed.
    std::string command(const std::string& line);
    /// True if the command moves on or back: one that a person repeats.
    static bool is_move(const std::string& line);
    bool is_over() const { return is_over_; }  ///< After "quit".

    Stepper& stepper() { return stepper_; }
    /// The first text for a new user.
    std::string welcome() const;

  private:
    using Words = std::vector<std::string>;
    struct Command;
    static std::span<const Command> commands();
    static std::vector<Command> move_commands();
    static std::vector<Command> look_commands();

    std::string step(const Words& words);
    std::string back(const Words& words);
    std::string primitive(const Words& words);
    std::string primitive_back(const Words& words);
    std::string part(const Words& words);
    std::string region(const Words& words);
    std::string frame(const Words& words);
    std::string go_on(const Words& words);
    std::string go_back(const Words& words);
    std::string go_to(const Words& words);
    std::string add_break(const Words& words);
    std::string remove_break(const Words& words);
    std::string list_breaks(const Words& words);
    std::string pixel(const Words& words);
    std::string list(const Words& words);
    std::string print(const Words& words);
    std::string show(const Words& words);
    std::string png(const Words& words);
    std::string where(const Words& words);
    std::string help(const Words& words);
    std::string quit(const Words& words);

    std::string to_stops(const Break& stop, std::int64_t times, const char* what);
    std::string run_to_breaks(Direction direction);
    void go_to_pixel(const Words& words);
    NamedField field_or_default(const Words& words, std::size_t index) const;

    Stepper stepper_;
    TerminalStyle style_;
    std::vector<int> break_numbers_;  ///< The numbers that the user sees.
    std::vector<Break> breaks_;
    int next_break_ = 1;
    bool is_over_ = false;
};

}  // namespace pxpl5::host::inspect
