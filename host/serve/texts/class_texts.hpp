// The texts of the page of a class, in English. {0} stands for a number.
#pragma once

#include <array>
#include <string_view>

namespace pxpl5::host::serve::class_text {

inline constexpr std::string_view starts = "Your session starts";
inline constexpr std::string_view starting = "This page shows it as soon as the volume is open.";
inline constexpr std::string_view first_start =
    "This page shows it as soon as the volume is open. It needs cookies.";
inline constexpr std::string_view has_ended = "Your session has ended";
inline constexpr std::string_view asked_to_end =
    "The session was asked to end, by 'pxpl5 sessions end' or a signal.";
inline constexpr std::string_view begin_anew = "Reload this page to begin a new one.";
inline constexpr std::string_view one_is_taken = "The only session is taken";
inline constexpr std::string_view all_are_taken = "All {0} sessions are taken";
inline constexpr std::string_view asks_again =
    "This page asks again every {0} seconds, and opens your session when one is free.";
inline constexpr std::string_view not_known = "This address is not known";
inline constexpr std::string_view no_such_page = "There is no such page";
inline constexpr std::string_view with_slash =
    "Open the whole address of the class, with the slash before '?'.";
inline constexpr std::string_view not_complete = "This address is not complete";
inline constexpr std::string_view with_token =
    "Open the whole address of the class, with its token.";
inline constexpr std::string_view open_again = "Open the address of the class again.";

/// All of the above.
inline constexpr std::array all{starts,       starting,     first_start,   has_ended,  asked_to_end,
                                begin_anew,   one_is_taken, all_are_taken, asks_again, not_known,
                                no_such_page, with_slash,   not_complete,  with_token, open_again};

}  // namespace pxpl5::host::serve::class_text
