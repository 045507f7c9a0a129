// Numbers as the page writes them.
const short = (value) => {
  if (!Number.isFinite(value)) return "–";
  const text = Number(value.toPrecision(3));
  return (Math.abs(text) >= 1e5 || (text !== 0 && Math.abs(text) < 1e-4)
    ? text.toExponential() : String(text)).replace(/-/g, "−");
};
const withSd = (value, sd) => {
  if (!(sd > 0 && Number.isFinite(value))) return short(value);
  const power = Math.max(Math.abs(value), sd) < 1e-4
    ? Math.floor(Math.log10(Math.max(Math.abs(value), sd))) : 0;
  const v = value / 10 ** power, s = sd / 10 ** power;
  const decimals = Math.min(Math.max(0, 1 - Math.floor(Math.log10(s))), 12);
  const text = `${v.toFixed(decimals)} ± ${s.toFixed(decimals)}`.replace(/-/g, "−");
  return power ? `(${text})e−${Math.abs(power)}` : text;
};
// A word of a command as a shell reads it.
const shellWord = (text) => (/^[\w@%+=:,.\/-]+$/.test(text)
  ? text : `'${text.replaceAll("'", "'\"'\"'")}'`);
const nice = (value) => {
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * NICE.find((m) => decade * m >= value * (1 - 1e-9));
};
