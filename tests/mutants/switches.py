"""All mutants of a file in one text, each behind a switch: the environment variable MUTANT is the number of the active one."""
import re

declaration = """#include <cstdlib>
#ifndef ANOGATE_MUTANT
#define ANOGATE_MUTANT
namespace mutants {
inline bool is_on(int number) noexcept {
    static const int on = std::getenv("MUTANT") ? std::atoi(std::getenv("MUTANT")) : 0;
    return on == number;
}
}
#endif
"""
opens, closes = "([{", ")]}"


def tokens(text):
    return re.findall(r"\w+|::|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%|&^]=|[^\w\s]", text)


def is_balanced(words):
    depth = []
    for word in words:
        if word in opens:
            depth.append(word)
        elif word in closes and word:
            if not depth or opens.index(depth.pop()) != closes.index(word):
                return False
    return not depth


def statements(words):
    """The number of statements; 0: they are incomplete."""
    if not is_balanced(words) or words and words[-1] not in (";", "}"):
        return 0
    count = depth = 0
    for word in words:
        depth += (word in opens) - (word in closes)
        count += depth == 0 and word in (";", "}")
    return max(count, 1)


def stripped(old, new):
    """The numbers of equal elements at the beginning and at the end of both."""
    first = 0
    while first < min(len(old), len(new)) and old[first] == new[first]:
        first += 1
    last = 0
    while last < min(len(old), len(new)) - first and old[-1 - last] == new[-1 - last]:
        last += 1
    return first, last


def as_statement(before, old, new):
    if not statements(old) or not statements(new):
        return None
    lead = ""
    if old[0] == "else":
        lead, old, new = "else ", old[1:], new[1:] if new[:1] == ["else"] else new
    elif before and (before[-1] in (")", "else")) and statements(old) > 1:
        return None
    if not old or old[0] in ("case", "default", "const", "auto"):
        return None
    return f"{lead}if (mutants::is_on(@)) {{ {' '.join(new)} }} else {{ {' '.join(old)} }}"


before_operand = {"(", ",", "=", "return", "&&", "||", "?", ":", "{", ";", "}", "+=", "-=", "<<"}
behind_operand = {")", ",", ";", "&&", "||", "?", ":", "}", "]"}


def as_operand(before, old, new, behind):
    if not old or not new or ";" in old + new or not is_balanced(old) or not is_balanced(new):
        return None
    if old[0] == "return" == new[0]:
        before, old, new, lead = ["return"], old[1:], new[1:], "return "
    else:
        lead = ""
    if not before or before[-1] not in before_operand or not behind or behind[0] not in behind_operand:
        return None
    if ("||" in old or "?" in old) and ("&&" in (before[-1], behind[0]) or "||" in (before[-1],)) or "=" in old:
        return None
    return f"{lead}(mutants::is_on(@) ? ({' '.join(new)}) : ({' '.join(old)}))"


def switch(before, old, new, behind):
    """The text that replaces `old`, with @ for the number; None: this change can't have a switch."""
    before, old, new, behind = tokens(before[-200:]), tokens(old), tokens(new), tokens(behind[:100])
    if any('"' in words or "'" in words for words in (old, new)):
        return None    # strings contain no tokens
    found = as_statement(before, old, new) or as_operand(before, old, new, behind)
    if found:
        return found
    first, last = stripped(old, new)
    end_old, end_new = len(old) - last, len(new) - last
    head, tail = old[:first], old[end_old:]
    inner = (as_statement(before + head, old[first:end_old], new[first:end_new]) if not head or head[-1] in (";", "{", "}") else None) \
        or as_operand(before + head, old[first:end_old], new[first:end_new], tail + behind)
    return f"{' '.join(head)} {inner} {' '.join(tail)}" if inner else None


def with_switches(text, changes):
    """`changes`: (number, first, last, replacement) of places in `text`. Returns the text with a switch for each that can have one, their
    numbers, and the lines of each in that text."""
    done, lines, end = [], {}, len(text)
    for number, first, last, new in sorted(changes, key=lambda c: -c[1]):
        if last > end:
            continue    # it overlaps another one
        found = switch(text[:first], text[first:last], new, text[last:])
        if found:
            text = text[:first] + "\n" + found.replace("@", str(number)) + "\n" + text[last:]
            end = first
            done.append(number)
    text = declaration + text
    for number, line in ((int(n), i) for i, whole in enumerate(text.split("\n"), 1) for n in re.findall(r"is_on\((\d+)\)", whole)):
        lines[line] = number
    return text, done, lines
