#!/bin/bash
# Wording of texts for people: string literals and comments of the sources, READMEs, the changelog and manual pages. Each row of the
# table below is a habit that made texts hard to read: a regular expression (Python), the reason, and a better way. Prints FILE:LINE, the
# text and both.
#   tools/check-words.sh [FILE...]    (default: all)
# A new row must have no false positives: run it over everything first.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
cd "$root"
need_packages python3:python3

python3 - "$@" 3<<'TABLE' <<'PROGRAM'
# English. Separators: two or more spaces around "|".
\bis a word too many\b  |  riddle  |  unexpected argument 'X'
\bis nothing to do\b  |  riddle  |  unknown action 'X'; actions: …
\bthere is no (command|option|link) '  |  clumsy  |  unknown command 'X'
\bthere is no terminal to ask\b  |  clumsy  |  confirmation required, but stdin is not a terminal; use --yes
\bis no (number|form|device|file|time)\b(?! in)  |  not idiomatic  |  is not a number
\bit can't be (read|written|made|removed)\b  |  passive, "it" for the file  |  FILE: cannot read: REASON
\bis there already\b  |  not idiomatic  |  already exists
\b(writes|written) over (a|the|any) file that\b  |  not idiomatic  |  overwrite existing files
\ba FILE has a name\b  |  riddle  |  FILE is an empty name
\bhad no room for\b  |  picture  |  N frames lost: the buffer of the gateway was full
\bof no frame\b  |  not idiomatic  |  N bytes outside any frame
\bcheck bytes do not hold\b  |  picture  |  wrong checksum
\bnothing came\b  |  a device does not "come"  |  no data received
\b(did not|does not|never) come(s)? (back )?(from|any more)\b  |  a frame does not "come"  |  not received
\bsays? again\b  |  software does not "say"  |  replay
\bwhat (was|is) said\b  |  software does not "say"  |  name the frames or the message
\bwhat devices (say|said|write|tell)\b  |  subject with "what", devices do not "say"  |  log messages of devices
\bwhat comes, leaves\b  |  riddle  |  received, sent or dropped frames
\bwho is there\b  |  a device is not a person  |  scan for devices
\bwho he is\b  |  a device is not a person  |  query all devices for their information
\bspeaks? only when spoken to: (run|let|try anogated)\b  |  devices do not "speak"  |  send only after a hello
\bitself never speaks\b  |  software does not "speak"  |  only receives
\b[Ee]nds after so (many|long)\b  |  "so many" without a measure  |  exit after N frames, stop after this time
\bso many times as fast\b  |  "so many" without a measure  |  speed factor
\b(object|line|frame|NAME=VALUE|fault) a line\b  |  "a" for "per"  |  one object per line
\bbefore or behind the command\b  |  "behind" for "after"  |  before or after the command
\bdamaged behind\b  |  "behind" for "after"  |  damaged after byte N
\bover a restart\b(?! with|:| and)  |  not idiomatic  |  saved permanently, after a restart
\bwhat its maker meant\b  |  riddle  |  factory defaults
\bdid not end\b  |  vague  |  was interrupted
\b[Gg]o on\?|all the same\?  |  not idiomatic  |  Continue? / Continue anyway?
\bthe door\b  |  picture  |  the HTTP interface, the port
\bis parted with\b  |  picture  |  is disconnected
\bholds? up a frame\b  |  picture  |  delays a frame
\bcan't be meant\b  |  riddle  |  usage error; the request is malformed
\b[Aa]ll went well\b  |  vague  |  success
\bif all is well\b|\bwhere it is not the usual one\b  |  vague  |  if not the default
\b(we|he|she) (says?|tells?|hears?|speaks?)\b  |  software is not a person  |  sends, receives, reports
\b[Nn]obody may\b|\b[Ww]ho may (change|connect|control)\b  |  subject "who"  |  write access, allowed senders
\bof nothing\b|\bnobody reads it\b  |  riddle  |  the reader closed the pipe
# Chinese
设备受得了  |  翻译腔  |  设备兼容性
再说一遍  |  设备不会“说”  |  回放
说的是 V8  |  设备不会“说”  |  使用的是 V8 协议
先有人说话才开口|听到上位机说话  |  设备不会“说”  |  需要先收到查询才会发送数据
才为人所知  |  翻译腔  |  才会登记
询问有谁在|问谁在那里|问所有设备谁在  |  设备不是人  |  扫描设备、查询所有设备
会说设备  |  软件不会“说”  |  会显示设备
谁也不能关闭  |  翻译腔  |  不允许关闭
说了算  |  口语  |  按第一条符合的规则处理
好帧  |  生造词  |  有效帧
读帧与造帧  |  生造词  |  帧的解码与编码
会说(从|正确|是谁|实际)  |  软件不会“说”  |  给出、显示
没有去处的  |  翻译腔  |  没有目的地的
TABLE
import glob, os, re, subprocess, sys

rows = []
with os.fdopen(3, encoding='utf-8') as table:
    for row in table.read().split('\n'):
        if row and not row.startswith('#'):
            pattern, reason, better = re.split(r'\s{2,}\|\s{2,}', row)
            rows.append((re.compile(pattern), reason, better))
any_row = re.compile('|'.join(f'(?:{row[0].pattern})' for row in rows))

# A literal of several parts is one text, at the line of its first part.
literals = re.compile(r'''R"(?P<mark>\w*)\((?P<raw>.*?)\)(?P=mark)"|(?P<text>"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*)'''
                      r"""|//[^\n]*|/\*.*?\*/|'(?:[^'\\\n]|\\.)'""", re.S)
script = re.compile(r'''"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\]|\\.)*`|//[^\n]*|/\*.*?\*/|>[^<>{}]+<''', re.S)


def texts_of(path):
    with open(path, encoding='utf-8') as file:
        text = file.read()
    if path.endswith(('.cpp', '.hpp')):
        for found in literals.finditer(text):
            if found['raw'] is not None:
                yield found.start(), found['raw']
            elif found['text'] is not None:
                yield found.start(), ''.join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', found['text']))
            elif found[0].startswith('/'):
                yield found.start(), found[0]
    elif path.endswith(('.ts', '.tsx')):
        for found in script.finditer(text):
            if not found[0].startswith('/'):
                yield found.start(), found[0][1:-1]
    else:
        start = 0
        for line in text.split('\n'):
            yield start, line
            start += len(line) + 1


files = sys.argv[1:] or subprocess.run(
    ['git', 'ls-files', '*README*.md', 'tools/packaging/CHANGELOG.md', 'tools/man/*', 'tools/run', 'tools/test', 'tools/package',
     'tools/setup.sh', 'include/*.hpp', 'src/*.cpp', 'src/*.hpp', 'tools/*.cpp', 'tools/*.hpp', 'src/web/src/*.ts', 'src/web/src/*.tsx'],
    capture_output=True, text=True, check=True).stdout.split()
found_any = False
for path in sorted(set(files)):
    if not os.path.exists(path):
        continue
    whole = None
    for start, text in texts_of(path):
        if not any_row.search(text):
            continue
        whole = whole or open(path, encoding='utf-8').read()
        for pattern, reason, better in rows:
            if match := pattern.search(text):
                found_any = True
                line = whole.count('\n', 0, start) + 1
                near = text[max(0, match.start() - 40):match.end() + 40].strip()
                print(f'{path}:{line}: "{near}": {reason}; better: {better}')
sys.exit(found_any)
PROGRAM
