// Returns the error text of a refused request.
#pragma once

#include <functional>
#include <string>

#include "host/base/error.hpp"

namespace pxpl5::test {

/// The text of the RequestError that `act` throws; empty if it throws none.
inline std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const host::RequestError& error) {
        return error.what();
    }
    return {};
}

}  // namespace pxpl5::test
