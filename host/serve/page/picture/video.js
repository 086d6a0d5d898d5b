// Decodes moving pictures that arrive as video.
import {say} from '../texts/say.js';

/** @typedef {import('../link/connection.js').Frame} Frame */

const MOST_FAILURES = 3;   // In a row. The browser then gets no video any more.
const PATIENCE_MS = 3000;  // A decoder that is silent for so long has failed.
const KEPT = 256;          // Length of each list; older values are dropped.

/**
 * VP8 says nothing about colors, and browsers guess by the size.
 * @type {VideoDecoderConfig}
 */
const CONFIG = {codec: 'vp8', optimizeForLatency: true, colorSpace: {primaries: 'bt709',
  transfer: 'iec61966-2-1', matrix: 'smpte170m', fullRange: false}};

/**
 * Figures for the tests.
 * @typedef {object} VideoFigures
 * @property {boolean} on           Whether the page has asked for video.
 * @property {number} decoded       Video frames since the page was opened.
 * @property {number} failures      Errors of the decoder since the page was opened.
 * @property {number[]} decode_ms   From the arrival of a frame to its picture.
 */

/**
 * A video frame depends on the frames before it, so each is decoded, in the order of arrival, also
 * if a newer frame has arrived in the meantime. After an error, the page asks for a new video,
 * which begins with a key frame; the frames until then are not shown. After several errors in a
 * row it asks for no video, and moving pictures are JPEG files.
 *
 * Browsers have decoders only in pages that come encrypted or from this computer.
 */
export class Video {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {(text: string) => void} tell  Informs the user.
   */
  constructor(connection, tell) {
    /** @private */
    this.connection_ = connection;
    /** @private */
    this.tell_ = tell;
    /** @private @type {VideoDecoder | null} */
    this.decoder_ = null;
    /** @private By time stamp. @type {Map<number, (picture: VideoFrame | null) => void>} */
    this.waiting_ = new Map();
    /** @private */
    this.failuresInARow_ = 0;
    /** @private */
    this.frames_ = 0;
    /** @private */
    this.isRefused_ = typeof VideoDecoder === 'undefined'
      || new URL(location.href).searchParams.get('video') === 'off';
    /** @type {VideoFigures} */
    this.figures = {on: false, decoded: 0, failures: 0, decode_ms: []};
    connection.on('hello', () => void this.ask_());
    connection.on('lost', () => this.close_());
  }

  /**
   * The picture of a video frame, to be closed; null if the frame cannot be decoded. Call once for
   * each frame, in the order of arrival.
   * @param {Frame} frame
   * @returns {Promise<VideoFrame | null>}
   */
  async decode({header, picture}) {
    const begin = performance.now();
    const decoded = await this.decodeNext_(header.key, picture);
    if (decoded) {
      this.failuresInARow_ = 0;
      this.figures.decoded += 1;
      this.figures.decode_ms.push(performance.now() - begin);
      this.figures.decode_ms.splice(0, this.figures.decode_ms.length - KEPT);
    }
    return decoded;
  }

  /**
   * @private
   * @param {boolean} isKey
   * @param {Uint8Array} data
   * @returns {Promise<VideoFrame | null>}
   */
  decodeNext_(isKey, data) {
    return new Promise(resolve => {
      try {
        if (isKey && !this.decoder_) {
          this.open_();
        }
      } catch (error) {
        this.failed_(error);
      }
      if (!this.decoder_) {
        resolve(null);
        return;
      }
      const timestamp = this.frames_++;
      const patience = setTimeout(() => {
        if (this.waiting_.has(timestamp)) {
          this.failed_(say`no picture within ${PATIENCE_MS} ms`);
        }
      }, PATIENCE_MS);
      this.waiting_.set(timestamp, picture => {
        clearTimeout(patience);
        resolve(picture);
      });
      try {
        this.decoder_.decode(new EncodedVideoChunk({type: isKey ? 'key' : 'delta', timestamp,
          data}));
      } catch (error) {
        this.failed_(error);
      }
    });
  }

  /** @private */
  open_() {
    /** @type {VideoDecoder} */
    const decoder = new VideoDecoder({
      output: picture => {
        const take = this.waiting_.get(picture.timestamp);
        this.waiting_.delete(picture.timestamp);
        take ? take(picture) : picture.close();
      },
      error: error => {
        if (decoder === this.decoder_) {
          this.failed_(error);
        }
      },
    });
    this.decoder_ = decoder;
    decoder.configure(CONFIG);
  }

  /** Gives null to whoever waits for a picture. @private */
  close_() {
    const decoder = this.decoder_, waiting = [...this.waiting_.values()];
    this.decoder_ = null;
    this.waiting_.clear();
    if (decoder && decoder.state !== 'closed') {
      decoder.close();
    }
    waiting.forEach(take => take(null));
  }

  /** @private @param {unknown} error */
  failed_(error) {
    this.figures.failures += 1;
    this.failuresInARow_ += 1;
    this.close_();
    if (this.failuresInARow_ >= MOST_FAILURES && !this.isRefused_) {
      this.isRefused_ = true;
      this.tell_(say`The browser cannot decode the video of moving pictures:
        ${error instanceof Error ? error.message : String(error)}. They are sent as JPEG instead,
        which needs a faster link.`);
    }
    void this.ask_();
  }

  /** Asks for a new video, or for none. @private */
  async ask_() {
    let isOn = !this.isRefused_;
    if (isOn) {
      try {
        isOn = (await VideoDecoder.isConfigSupported(CONFIG)).supported ?? false;
      } catch {
        isOn = false;
      }
    }
    isOn &&= !this.isRefused_;  // It may have failed again meanwhile.
    this.figures.on = isOn;
    this.connection_.wantVideo(isOn);
  }
}
