// Chinese translations of the gateway's texts about the progress of jobs. Other texts remain English.

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
