// Converts the words of each form to a value. Used only by the table in form.cpp.
#pragma once
#include <config/key_facts.hpp>

#include <string>

namespace anogate::read_value {

/// Each function sets `value` and returns "", or returns the error.
std::string boolean(const KeyFacts& key, const Words& words, Value& value);
std::string integer(const KeyFacts& key, const Words& words, Value& value);
std::string address(const KeyFacts& key, const Words& words, Value& value);
std::string can_id(const KeyFacts& key, const Words& words, Value& value);
std::string size(const KeyFacts& key, const Words& words, Value& value);
std::string addresses(const KeyFacts& key, const Words& words, Value& value);
std::string duration(const KeyFacts& key, const Words& words, Value& value);
std::string interval(const KeyFacts& key, const Words& words, Value& value);
std::string silence(const KeyFacts& key, const Words& words, Value& value);
std::string choice(const KeyFacts& key, const Words& words, Value& value);
std::string choice_or_link(const KeyFacts& key, const Words& words, Value& value);
std::string text(const KeyFacts& key, const Words& words, Value& value);
std::string decimal(const KeyFacts& key, const Words& words, Value& value);
std::string names(const KeyFacts& key, const Words& words, Value& value);
std::string endpoint(const KeyFacts& key, const Words& words, Value& value);
std::string host(const KeyFacts& key, const Words& words, Value& value);
std::string networks(const KeyFacts& key, const Words& words, Value& value);
std::string network(const KeyFacts& key, const Words& words, Value& value);
std::string ip(const KeyFacts& key, const Words& words, Value& value);
std::string frames(const KeyFacts& key, const Words& words, Value& value);
std::string senders(const KeyFacts& key, const Words& words, Value& value);
std::string limit(const KeyFacts& key, const Words& words, Value& value);

}    // namespace anogate::read_value
