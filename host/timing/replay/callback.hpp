// A small function to be called later, kept in place: no memory is asked for.
#pragma once

#include <array>
#include <cstddef>
#include <new>
#include <type_traits>

namespace pxpl5::host::timing {

template <class... Arguments>
class Callback {
  public:
    Callback() = default;

    /// Not explicit, as std::function's.
    template <class F>
    requires std::is_invocable_v<F, Arguments...> Callback(F function) {
        static_assert(sizeof(F) <= room && std::is_trivially_copyable_v<F> &&
                      std::is_trivially_destructible_v<F>);
        ::new (static_cast<void*>(kept_.data())) F(function);
        call_ = [](void* kept, Arguments... arguments) { (*static_cast<F*>(kept))(arguments...); };
    }

    explicit operator bool() const { return call_ != nullptr; }
    void operator()(Arguments... arguments) { call_(kept_.data(), arguments...); }

  private:
    static constexpr std::size_t room = 24;
    void (*call_)(void*, Arguments...) = nullptr;
    alignas(std::max_align_t) std::array<std::byte, room> kept_{};
};

}  // namespace pxpl5::host::timing
