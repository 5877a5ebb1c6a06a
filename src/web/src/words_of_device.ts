// Chinese translations of the gateway's texts about jobs: progress and errors. Other texts remain English.

const messages: Record<string, string> = {
  "reading parameters": "正在读取参数",
  "writing parameters": "正在写入参数",
  "comparing parameters": "正在比较参数",
  "save": "正在保存",
  "restore_defaults": "正在恢复出厂值",
  "reading commands": "正在读取命令",
  "reading waypoints": "正在读取航点",
  "writing waypoints": "正在写入航点",
  "checking the file": "正在检查文件",
  "device info": "设备信息",
  "description of the image": "发送固件说明",
  "erasing": "正在擦除",
  "sending": "正在发送固件",
  "check of the image": "设备正在校验固件",
  "checking that it is not flying": "正在确认它没有飞行",
  "reading the old values": "正在读取旧值",
  "saving the old values": "正在保存旧值",
  "The old values are saved. Continue when you are ready to turn the device": "旧值已保存。准备好转动设备后请继续",
  "clearing the calibration of the device": "正在清除设备的旧校准值",
  "lay it on each of its six faces": "把设备的六个面依次朝上静置",
  "turn it to all sides": "把设备转向各个方向",
  "checking that no sample was corrected": "正在确认采样没有经过旧校准修正",
  "saving the new values": "正在保存新值",
  "writing the new values": "正在写入新值",
  "checking the new values: keep turning it": "正在验证新值：请继续转动",
  "the device does not show whether it was cleared, so the new values are checked on all sides: lay it on each of its six faces again": "无法确认设备是否清除了旧值，因此需要在各个方向上验证新值：请再次把六个面依次朝上静置",
  "the device does not show whether it was cleared, so the new values are checked on all sides: turn it to all sides again": "无法确认设备是否清除了旧值，因此需要在各个方向上验证新值：请再次把设备转向各个方向",
  "writing the old values back": "正在写回旧值",
  "restoring the values from before an unfinished calibration": "正在恢复未完成的校准之前的值",
};

const reasons: [RegExp, string][] = [
  [/^(.+) is unlocked or flying: this is only allowed on the ground$/, "$1 已解锁或在飞行中：此操作只能在地面上进行"],
  [/^no answer to (.+): it may have been carried out$/, "没有收到对 $1 的确认：它可能已经执行了"],
  [/^not sent: it waited too long in the queue of the link '(.+)', which is too slow$/, "没有发送：链路 $1 太慢，在队列里等待过久"],
  [/^not sent: the queue of the link '(.+)' is full$/, "没有发送：链路 $1 的队列已满"],
  [/^not sent: the link '(.+)' is down$/, "没有发送：链路 $1 已断开"],
  [/^not sent: the link '(.+)' could not send it$/, "没有发送：链路 $1 无法发出"],
  [/^not sent: refused by the rules of V7 of the link '(.+)': (.+)$/, "没有发送：链路 $1 的 V7 规则不允许（$2）"],
  [/^(0x\w\w) is online, but did not answer the request for its (.+), sent (\d+) times?(?:; .+)?$/, "$1 在线，但没有应答对 $2 的请求，已发送 $3 次"],
  [/^(0x\w\w) is online, but did not acknowledge: (.+), sent (\d+) times?(?:; .+)?$/, "$1 在线，但没有确认 $2，已发送 $3 次"],
  [/^(0x\w\w) does not answer: (.+), sent (\d+) times?$/, "$1 没有应答：$2，已发送 $3 次"],
  [/^(0x\w\w) stopped sending: nothing was received for (.+) s$/, "$1 停止发送：$2 秒内没有收到数据"],
  [/^(0x\w\w) stopped answering: (.+)$/, "$1 中途停止应答：$2"],
  [/^(0x\w\w) answers other requests, but not the description of the image: it has no boot loader$/, "$1 应答其他请求，但不应答固件信息：它没有引导程序"],
  [/^(0x\w\w) is online, but does not answer: (.+)$/, "$1 在线，但没有应答：$2"],
  [/^(0x\w\w) sent 0xF0 with (.+), which is not a valid answer: (.+)$/, "$1 发来 0xF0 $2，不是有效的应答：$3"],
  [/^(0x\w\w) was not seen and does not answer$/, "没有收到过 $1 的数据，它也没有应答"],
  [/^(0x\w\w) acknowledged with wrong check bytes \((.+)\): (.+), sent (\d+) times?$/, "$1 的确认中校验字节错误（$2）：$3，已发送 $4 次"],
  [/^(0x\w\w) acknowledged (.+) with wrong check bytes \((.+)\): it has probably been carried out$/, "$1 对 $2 的确认中校验字节错误（$3）：它很可能已经执行了"],
  [/^(0x\w\w) acknowledged (.+), which was sent more than once: the acknowledgement does not show which of them was carried out$/, "$1 确认了 $2，但它发送过不止一次：无法确定执行的是哪一次"],
  [/^(0x\w\w) did not keep these waypoints \(it has probably restarted\): (.+)$/, "$1 没有保留这些航点（很可能重新启动过）：$2"],
  [/^cancelled, nothing was changed$/, "已取消，没有任何更改"],
  [/^cancelled, some values may be written$/, "已取消，有些值可能已经写入"],
  [/^cancelled after (\d+) of (\d+)$/, "已取消，做了 $2 项中的 $1 项"],
  [/^cancelled$/, "已取消"],
  [/^rejected: the six faces are inconsistent: lay it flat on each$/, "新值未采用：六个面的数据不一致，请把每个面都放平"],
  [/^rejected: the residual is (.+) cm\/s²: lay it flat on each$/, "新值未采用：残差有 $1 cm/s²，每个面都要放平"],
  [/^rejected: the old values are as good: the residual is (.+), and would be (.+)$/, "新值未采用：旧值同样好，残差是 $1，用新值会是 $2"],
  [/^rejected: the residual would be (.+), and is (.+)$/, "新值未采用：残差会是 $1，现在是 $2，没有变好"],
  [/^rejected: the device can't store the new values precisely enough$/, "新值未采用：设备存储的精度不够"],
  [/^rejected: as the device stores the new values, the residual would be (.+), and is (.+)$/, "新值未采用：按设备存储的精度，残差会是 $1，现在是 $2，没有变好"],
  [/^rejected: as the device stores the new values, the largest error would be (.+), and is (.+)$/, "新值未采用：按设备存储的精度，最大误差会是 $1，现在是 $2，没有变好"],
  [/^rejected: only (.+) of all directions were measured$/, "新值未采用：只测到 $1 的方向"],
  [/^rejected: the samples don't form an ellipsoid: turn it slowly, away from iron$/, "新值未采用：采样不构成椭球，请远离铁磁物体慢慢转动"],
  [/^the image did not pass the device's check$/, "固件没有通过设备的校验"],
  [/^the device could not erase$/, "设备擦除失败"],
  [/^the device could not write frame (\d+)$/, "设备无法写入第 $1 帧"],
  [/^it is for hardware (.+), the device is (.+)$/, "固件适用于硬件 $1，设备是 $2"],
  [/^it is for hardware versions (.+) to (.+), the device is (.+)$/, "固件适用硬件版本 $1 到 $2，设备是 $3"],
  [/^the file is empty$/, "文件是空的"],
  [/^(.+): (.+) is out of range$/, "$1：$2 超出范围"],
  [/^(.+): (.+) is not a number$/, "$1：$2 不是数"],
  [/^(.+): (.+) is not whole$/, "$1：$2 不是整数"],
  [/^(.+) has a value of type 7, .+: state it once \(type7\)$/, "$1 有类型 7 的值：老设备里是 f32，新设备里是 u64，设备的描述没有说明是哪一种，请指明一次（type7）"],
  [/^command (.+) is not (.+) any more: read the commands again$/, "编号 $1 的命令已不是 $2，请重新读取命令"],
  [/^(.+) keeps (.+) at (.+)$/, "$1 没有接受，$2 仍是 $3"],
  [/^(.+) is already being recorded$/, "$1 已在录制"],
  [/^(\d+) requested recordings are already in progress: stop one of them$/, "已有 $1 个录制正在进行：请先停止一个"],
  [/^(.+) is still being recorded: stop it before you delete it$/, "$1 正在录制：请先停止再删除"],
  [/^recording did not start: (.+)$/, "录制没有开始：$1"],
  [/^(.+): No space left on device$/, "$1：磁盘已满"],
  [/^(.+): only (.+) of disk space is free, and recording needs (.+?)(?:: .+)?$/, "$1：磁盘只剩 $2，至少需要 $3 才能继续录制"],
  [/^the disk has written nothing for (\d+) s$/, "磁盘已有 $1 秒没有写入任何数据"],
  [/^the disk is too slow; frames are being lost$/, "磁盘太慢，正在丢失帧"],
  [/^the disk is too slow; frames are waiting$/, "磁盘太慢，帧在等待写入"],
  [/^(.+): Read-only file system$/, "$1：文件系统只读"],
  [/^(.+): Input\/output error$/, "$1：磁盘读写出错"],
  [/^(.+): (?:Not a directory|File exists)$/, "$1：不是文件夹"],
  [/^(.+): Permission denied$/, "$1：没有权限"],
  [/^(.+): No such file or directory$/, "$1：没有这个文件"],
  [/^(.+): is not a regular file$/, "$1：不是普通文件"],
  [/^not a PMTiles file of version 3$/, "不是版本 3 的 PMTiles 文件"],
  [/^its tiles are not images: only raster tiles are supported$/, "瓦片不是图片：只能显示栅格瓦片"],
  [/^its directories are not compressed with gzip$/, "目录不是用 gzip 压缩的"],
  [/^it has zooms (\d+) to (\d+)$/, "它的缩放级别是 $1 到 $2"],
  [/^a tile is not an image$/, "瓦片不是图片，文件可能已损坏"],
  [/^a tile is too large$/, "瓦片太大"],
  [/^(?:a directory is damaged|a directory (?:is too large|ends too early|has too many entries|has no start offset)|its first directory is not where it must be|its directories form a loop|a number in a directory is too large|an offset beyond 2\^53)$/, "文件已损坏：目录读不懂"],
  [/^the map file was replaced$/, "地图文件换过了"],
  [/^not continued within 10 minutes; nothing was changed$/, "10 分钟内没有继续；没有任何更改"],
  [/^it was not turned to all sides within 10 minutes$/, "10 分钟内没有转遍所有方向"],
  [/^the new values were not written, because they could not be saved: (.+)$/, "新值没有写入，因为无法保存：$1"],
  [/^(0x\w\w) restarted (\d+) times \(.+\)$/, "$1 重启了 $2 次：请检查供电和接线"],
  [/^(0x\w\w) is online, but sends no samples: (.+)$/, "$1 在线，但没有发送采样：$2"],
  [/^not verified: with the new values the error is (.+?)( on [+-][xyz])? instead of (.+)$/, "新值未通过验证：误差是 $1，应为 $3"],
  [/^not verified: with the new values the error is (.+) on all sides, with the old ones by (.+)$/, "新值未通过验证：各个方向上的误差是 $1，旧值是 $2"],
  [/^not verified: with the new values the error is (.+) on all sides, where (.+) is possible: some of its samples were not raw$/, "新值未通过验证：各个方向上的误差是 $1，本可以达到 $2：有些采样已经被旧校准修正过"],
  [/^(0x\w\w) acknowledges the clear and ignores it: .+$/, "$1 确认了清除却没有执行：它的校准值没有清除，采样两次都已被修正过"],
  [/^the new values could not be verified: it did not lie still on (..) when they were stored$/, "无法验证新值：存入后没有保持 $1 朝上静置"],
  [/^the new values could not be verified: it was not turned when they were stored$/, "无法验证新值：存入后没有继续转动"],
];

/** Also translates texts with numbers: "sending, 12.3 KB/s, 40 s left". */
export function messageInChinese(message: string): string {
  const [first = "", ...rest] = message.split(", ");
  const whole = messages[message];
  if (whole !== undefined) return whole;
  const restarted = /^the device restarted \(.+\), so all samples are discarded: (.+)$/.exec(message);
  if (restarted) return `设备重启过，之前的采样全部作废：${messageInChinese(restarted[1] ?? "")}`;
  const onFace = /^checking the new values: keep it still on (..)$/.exec(message);
  if (onFace) return `正在验证新值：请保持 ${onFace[1]} 朝上不动`;
  const onOther = /^checking the new values: lay it on (..) and keep it still$/.exec(message);
  if (onOther) return `正在验证新值：请再让 ${onOther[1]} 朝上静置`;
  const known = messages[first];
  if (known !== undefined) return [known, ...rest.map((one) => one.replace(/^(\d+) s left$/, "还要 $1 秒").replace("KB/s", "KB/秒"))].join("，");
  return message.replace(/^reading /, "正在读取 ").replace(/^writing /, "正在写入 ").replace(/^calling /, "正在执行 ");
}

const actions: Record<string, string> = {
  "reading parameters": "读取参数", "writing a parameter": "写入参数", "writing parameters": "写入参数", "saving or restoring parameters": "保存或恢复参数", "reading commands": "读取命令",
  "calling a command": "执行命令", "reading waypoints": "读取航点", "writing waypoints": "写入航点", "firmware upgrade": "固件升级", "calibration": "校准", "scan": "扫描",
};

export function reasonInChinese(error: string): string {
  const used = /^(.+) is used by job (\d+) \(([^,]+?)(?:, by (.+))?\)$/.exec(error);
  if (used) return `${used[1]} 正被任务 ${used[2]}（${actions[used[3]!] ?? used[3]}${used[4] ? `，来自 ${used[4]}` : ""}）占用`;
  for (const [pattern, chinese] of reasons) if (pattern.test(error)) return error.replace(pattern, chinese);
  return error;
}
