/** Reads the stream of records that an answer is: see `record.rs`. */

export const END = 0;
export const DOCUMENT = 1;
export const ROW = 2;
export const NUMBERS = 3;
export const FILE = 4;
export const PROGRESS = 5;
export const REMARK = 6;
export const REFUSAL = 7;

/** @typedef {{ kind: number, content: Uint8Array }} Message */

/** Puts records together from pieces of the stream, wherever they are cut. */
export class Reader {
    constructor() {
        /** @type {Uint8Array[]} */
        this.pieces = [];
        this.held = 0;
    }

    /**
     * @param {Uint8Array} piece
     * @returns {Message[]} the records that are complete now
     */
    take(piece) {
        this.pieces.push(piece);
        this.held += piece.length;
        const messages = [];
        for (;;) {
            const head = this.front(8);
            if (!head) break;
            const view = new DataView(head.buffer, head.byteOffset, 8);
            const length = view.getUint32(0, true);
            const kind = view.getUint32(4, true);
            const whole = this.front(8 + length);
            if (!whole) break;
            messages.push({ kind, content: whole.slice(8) });
            this.drop(8 + length);
        }
        return messages;
    }

    /**
     * The first bytes in one piece; none where there are not so many yet.
     * @param {number} count
     * @returns {Uint8Array | null}
     */
    front(count) {
        if (this.held < count) return null;
        if (this.pieces[0].length < count) {
            const joined = new Uint8Array(this.held);
            let at = 0;
            for (const piece of this.pieces) {
                joined.set(piece, at);
                at += piece.length;
            }
            this.pieces = [joined];
        }
        return this.pieces[0].subarray(0, count);
    }

    /** @param {number} count */
    drop(count) {
        this.held -= count;
        this.pieces[0] = this.pieces[0].subarray(count);
        if (this.pieces[0].length === 0) this.pieces.shift();
    }
}

const decoder = new TextDecoder();

/** @param {Message} message */
export const text = (message) => decoder.decode(message.content);

/**
 * @param {Message} message
 * @returns {any}
 */
export const document_of = (message) => JSON.parse(text(message));

/** @param {Message} message */
export const numbers = (message) => {
    const { buffer, byteOffset, byteLength } = message.content;
    return new Float64Array(buffer.slice(byteOffset, byteOffset + byteLength));
};

/**
 * @param {Message} message
 * @returns {{ name: string, bytes: Uint8Array }}
 */
export const file = (message) => {
    const { content } = message;
    const length = new DataView(content.buffer, content.byteOffset).getUint32(0, true);
    return { name: decoder.decode(content.subarray(4, 4 + length)), bytes: content.slice(4 + length) };
};
