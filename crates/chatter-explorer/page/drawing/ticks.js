/** Ticks of axes and numbers as text. */

/**
 * Round values between two others.
 * @param {number} low
 * @param {number} high
 * @param {number} most
 * @returns {{ values: number[], step: number }}
 */
export function ticks(low, high, most) {
    const span = high - low;
    if (!(span > 0) || !Number.isFinite(span)) return { values: [], step: 0 };
    const raw = span / Math.max(1, most);
    const decade = 10 ** Math.floor(Math.log10(raw));
    const step = decade * ([1, 2, 5, 10].find((factor) => factor * decade >= raw) ?? 10);
    const values = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k += 1) {
        values.push(k === 0 ? 0 : k * step);
        if (values.length > 100) break;
    }
    return { values, step };
}

const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** @param {number} power */
const raised = (power) =>
    (power < 0 ? "⁻" : "") + [...String(Math.abs(power))].map((digit) => SUPERSCRIPT[Number(digit)]).join("");

/** @param {number} power */
export const ten_to = (power) => (power === 0 ? "1" : power === 1 ? "10" : `10${raised(power)}`);

/** @param {string} text */
const minus = (text) => text.replace("-", "−");

/**
 * The texts of all ticks of an axis in one notation, and the power of ten that stands beside the axis for all of them.
 * @param {number[]} values
 * @param {number} step
 * @returns {{ texts: string[], factor: string }}
 */
export function tick_texts(values, step) {
    const largest = Math.max(...values.map(Math.abs), step);
    let power = Math.floor(Math.log10(largest) + 1e-9);
    if (power >= -3 && power < 5) power = 0;
    const unit = 10 ** power;
    const digits = Math.min(15, Math.max(0, -Math.floor(Math.log10(step / unit) + 1e-9)));
    return {
        texts: values.map((value) => minus((value / unit).toFixed(digits))),
        factor: power === 0 ? "" : `×10${raised(power)}`,
    };
}

/**
 * A number for people: so many digits, no trailing zeros.
 * @param {number} value
 * @param {number} [digits]
 */
export function shown(value, digits = 6) {
    if (!Number.isFinite(value)) return Number.isNaN(value) ? "–" : minus(value > 0 ? "∞" : "-∞");
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e7)) {
        const [mantissa, power] = value.toExponential(digits - 1).split("e");
        return minus(`${mantissa.replace(/\.?0+$/, "")}×10${raised(Number(power))}`);
    }
    const text = value.toPrecision(digits);
    return minus(text.includes(".") ? text.replace(/\.?0+$/, "") : text);
}

/**
 * A number with the digits that tell it from its neighbours at this step, for questions.
 * @param {number} value
 * @param {number} step
 */
export function rounded(value, step) {
    const digits = Math.min(17, Math.max(0, Math.ceil(Math.log10(Math.abs(value) / step)) + 1));
    return Number(value.toPrecision(Math.max(1, digits)));
}
