// A body for Beast that grows as data arrive. The user of this header includes Beast.
#pragma once
#include <http/asio.hpp>

#include <cstddef>
#include <string>

namespace anogate::http {

/// Beast's own body reserves the announced length at once, however large.
struct GrowingBody {
    using value_type = std::string;

    class reader {
    public:
        template <class Header>
        reader(Header&, value_type& body) : body_{body} {}

        template <class Size>
        void init(const Size&, error_code& ec) {
            ec = {};
        }
        template <class Buffers>
        std::size_t put(const Buffers& buffers, error_code& ec) {
            ec = {};
            std::size_t size = 0;
            for (auto at = asio::buffer_sequence_begin(buffers); at != asio::buffer_sequence_end(buffers); ++at) {
                const asio::const_buffer part = *at;
                body_.append(static_cast<const char*>(part.data()), part.size());
                size += part.size();
            }
            return size;
        }
        void finish(error_code& ec) { ec = {}; }

    private:
        value_type& body_;
    };
};

}    // namespace anogate::http
