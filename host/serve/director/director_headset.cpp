// Director: the pairs of pictures for a viewer who wears a headset.
#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/reply.hpp"
#include "host/serve/director/director.hpp"
#include "host/serve/encoding/reduce.hpp"

namespace pxpl5::host::serve {

namespace {

/// A headset without a message for this time may be replaced by another viewer's: the link to its
/// page may be dead, which the server notices later.
constexpr double silent_ms = 5000;
constexpr int eyes_of_a_pair = 2;

std::size_t pixels_of_pair(const Size& eye) {
    return static_cast<std::size_t>(eyes_of_a_pair) * static_cast<std::size_t>(eye.width) *
           static_cast<std::size_t>(eye.height);
}

/// The words of each eye: behind, then in front.
SharedWords by_eye(const SharedWords& behind, const SharedWords& front) {
    std::vector<std::uint32_t> words;
    words.reserve(behind.size() + front.size());
    const auto half = static_cast<std::ptrdiff_t>(behind.size() / eyes_of_a_pair);
    for (std::ptrdiff_t first = 0; first < eyes_of_a_pair * half; first += half) {
        words.insert(words.end(), behind.begin() + first, behind.begin() + first + half);
        words.insert(words.end(), front.begin() + first, front.begin() + first + half);
    }
    return words;
}

/// The frame of a pair; with one transparent surface, of two layers for each eye.
Shown pair_of(Frames& frames, const Eyes& eyes, const Frames::Moving& how) {
    Shown frame;
    frame.views = eyes_of_a_pair;
    frame.width = how.size.width;
    frame.height = how.size.height;
    if (const auto layers = frames.draw_pair_layers(eyes, how)) {
        frame.layers = 2;
        frame.opacity = layers->opacity;
        frame.pixels = by_eye(layers->behind.rgba, layers->front.rgba);
        frame.depths = by_eye(layers->behind.depths, layers->front.depths);
        return frame;
    }
    const Picture picture = frames.draw_pair(eyes, how);
    frame.pixels = picture.rgba;
    frame.depths = picture.depths;
    return frame;
}

}  // namespace

/// Keeps the newest eyes. Eyes of null end the headset.
void Director::take_eyes(std::uint32_t viewer, const ViewerMessage& message) {
    if (!message.eyes) {
        if (headset_.viewer == viewer) {
            take_headset_off();
        }
        answer_eyes(viewer, message.id, false);
        return;
    }
    const HeadsetEyes& eyes = *message.eyes;
    if (headset_.viewer != viewer) {
        if (headset_.viewer != 0 && since_ms(headset_.eyes_ns) < silent_ms) {
            refuse_command(
                "eyes: another viewer wears a headset, and the machine draws for one at "
                "a time. Try again when it is taken off");
        }
        take_headset_off();
        headset_.viewer = viewer;
    }
    if (headset_.eyes && eyes.pose <= headset_.eyes->pose) {
        refuse_command(
            fmt::format("eyes: pose {} is not newer than pose {}", eyes.pose, headset_.eyes->pose));
    }
    if (headset_.id) {
        answer_eyes(viewer, headset_.id, true);
    }
    headset_.eyes = eyes;
    headset_.id = message.id;
    headset_.eyes_ns = parts_.clock_ns();
    audience_.wear(viewer, pixels_of_pair(eyes.size));
}

void Director::answer_eyes(std::uint32_t viewer, std::optional<std::uint32_t> id,
                           bool is_superseded) {
    if (id) {
        Fields fields{{"re", std::int64_t{*id}}, {"ok", true}};
        if (is_superseded) {
            fields.push_back({"superseded", true});
        }
        audience_.send(viewer, json_text(fields));
    }
}

void Director::take_headset_off() {
    if (headset_.viewer != 0) {
        answer_eyes(headset_.viewer, headset_.id, true);
        audience_.wear(0, 0);
    }
    headset_ = {};
}

/// Whether a viewer who wears no headset looks, or no viewer has joined yet.
bool Director::has_onlookers() const {
    return headset_.viewer == 0 || viewers_.size() > 1;
}

/// Whether the wearer would take a pair that differs from the newest.
bool Director::is_pair_due() const {
    return headset_.eyes && audience_.wants_pair() &&
           (headset_.id || (has_picture() && (headset_.pose != headset_.eyes->pose ||
                                              headset_.revision != revision_)));
}

/// Draws a pair for the newest eyes. Returns false if none is due.
bool Director::draw_pair() {
    if (!is_pair_due()) {
        return false;
    }
    if (state_is_old_) {
        tell_state();
    }
    const HeadsetEyes eyes = *headset_.eyes;  // Newer eyes may come while the machine draws.
    Wish wish;
    wish.viewer = headset_.viewer;
    wish.id = std::exchange(headset_.id, std::nullopt);
    const std::int64_t start_ns = parts_.clock_ns();
    std::uint32_t revision = revision_;
    std::optional<Shown> pair;
    std::string failure = "eyes: the pair was not drawn. The error before this one has the reason";
    guard("drawing", [&] {
        revision = revision_;
        if (!has_picture()) {
            failure = "eyes: no volume is open. Open a volume first";
            return;
        }
        try {
            const double scale = std::min(headset_.pace.scale(), audience_.advice().pair_scale);
            pair = pair_of(session_->frames, eyes.eyes,
                           {moving_size(eyes.size, scale), moving_detail(eyes_of_a_pair)});
        } catch (const RequestError& error) {
            failure = fmt::format("eyes: {}", error.what());
        }
    });
    if (headset_.viewer == wish.viewer) {  // Else the headset was taken off meanwhile.
        headset_.pace.drawn(since_ms(start_ns));
        headset_.drawn_ns = parts_.clock_ns();
        headset_.pose = eyes.pose;
        headset_.revision = revision;  // Also after a failure: the next change tries again.
        headset_.had_turn = true;
    }
    if (!pair) {
        refuse(wish, RequestError(ExitCode::failed, failure));
        return true;
    }
    pair->viewer = wish.viewer;
    pair->pose = eyes.pose;
    pair->revision = revision;
    send_drawn(std::move(*pair));
    answer_eyes(wish.viewer, wish.id, false);
    return true;
}

/// Sends a frame that was just drawn.
void Director::send_drawn(Shown frame) {
    frame.moved_mm = session_->frames.last().moved_mm;
    frame.machine_ms = static_cast<float>(session_->frames.last().elapsed_ms);
    audience_.show(std::move(frame));
}

/// Draws a pair, or a picture of the state's camera for the others. They take turns if both are
/// due. A frame that was requested ahead goes first, because a pair would drop the frame.
///
/// rests  Also draws the resting picture.
bool Director::draw_in_turn(bool rests) {
    const auto draw_for_others = [&] { return draw_moving() || (rests && draw_resting()); };
    if (headset_.had_turn || session_->frames.has_frame_ahead()) {
        return draw_for_others() || draw_pair();
    }
    return draw_pair() || draw_for_others();
}

/// Milliseconds until the resting picture may be drawn. Its refinements, which take long, wait
/// until no new pose of a headset has come for as long.
double Director::rest_due_ms() const {
    const double input_due_ms = rest_ms - since_ms(input_ns_);
    const bool is_refinement =
        shown_.revision == revision_ && shown_.samples > 0 && !lacks_depths();
    return headset_.eyes && is_refinement
               ? std::max(input_due_ms, rest_ms - since_ms(headset_.eyes_ns))
               : input_due_ms;
}

}  // namespace pxpl5::host::serve
