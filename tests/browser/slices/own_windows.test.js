// The windows of a DICOM file, and standardized uptake values of PET.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { element, sequence, writeSeries } from '../dicom.js';
import { byId, page, server, usePage } from '../harness.js';
import { stateWhen } from '../steps.js';

usePage();

/** Opens a series with some elements more, and returns its state. */
async function openWith(name, side, modality, elements) {
  const folder = path.join(server.folder, name);
  writeSeries(folder, [{ description: name, side, modality, elements }]);
  await byId('open-panel').click();
  await byId('open-folder').setInputFiles(folder);
  const { volume } = await stateWhen(page, (now, is) => now.volume?.size[2] === is && !now.busy,
                                     side);
  await byId('tab-slices').click();
  await byId('slices-readout').getByText('crosshair').waitFor();
  return volume;
}

async function windowShown() {
  return [await byId('slices-window').inputValue(), await byId('slices-level').inputValue()];
}

test('a CT begins with the window of its file, and has a button for each', async () => {
  await openWith('chest', 10, 'CT', [element(0x0028, 0x1050, 'DS', '-600\\300'),
    element(0x0028, 0x1051, 'DS', '1500\\2000'), element(0x0028, 0x1055, 'LO', 'LUNG')]);
  assert.deepEqual(await windowShown(), ['1500', '-600']);
  assert.equal(await byId('window-own-0').innerText(), 'LUNG');
  assert.equal(await byId('window-own-1').innerText(), 'File 2');
  await byId('window-own-1').click();
  assert.deepEqual(await windowShown(), ['2000', '300']);
  await byId('window-Bone').click();
  assert.deepEqual(await windowShown(), ['1800', '400'], 'the presets of CT are there, too');
});

test('PET begins with uptake from 0 to 10, and tells the uptake of a voxel', async () => {
  // 50 kg and 200 MBq, of which half is left an hour later.
  const { unit, suv_per_value } = await openWith('tumor', 12, 'PT', [
    element(0x0054, 0x1001, 'CS', 'BQML'), element(0x0054, 0x1102, 'CS', 'START'),
    element(0x0028, 0x0051, 'CS', 'DECY\\ATTN'), element(0x0010, 0x1030, 'DS', '50'),
    element(0x0008, 0x0021, 'DA', '20240229'), element(0x0008, 0x0031, 'TM', '100000'),
    element(0x0008, 0x0022, 'DA', '20240229'), element(0x0008, 0x0032, 'TM', '100000'),
    sequence(0x0054, 0x0016, [element(0x0018, 0x1072, 'TM', '090000'),
      element(0x0018, 0x1074, 'DS', '200000000'), element(0x0018, 0x1075, 'DS', '3600')])]);
  assert.equal(unit, 'Bq/ml');
  assert.ok(Math.abs(suv_per_value - 0.0005) < 1e-12, `${suv_per_value}`);
  assert.deepEqual(await windowShown(), ['20000', '10000']);
  assert.equal(await byId('window-own-1').innerText(), 'SUV 0 to 10');
  // The crosshair is in the ball of 400.
  assert.match(await byId('slices-readout').innerText(), /^400 Bq\/ml \(SUV 0\.2\)/);
  await byId('window-own-0').click();
  assert.deepEqual(await windowShown(), ['10000', '5000']);
  await byId('tab-volume').click();
  assert.match(await byId('volume-facts').innerText(), /value × 0\.0005/);
});
