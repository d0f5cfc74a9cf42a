// An address to copy.
import {button, h} from './dom.js';

export function copyBox(label, address) {
  const id = `copy-${crypto.randomUUID()}`;
  const copied = h('span', {role: 'status', class: 'soft'});
  const box = h('input', {
    id, type: 'text', readonly: true, value: address, onfocus: event => event.target.select()
  });
  const copy = async () => {
    await navigator.clipboard?.writeText(address).catch(() => {});
    copied.textContent = 'Copied.';
  };
  return h('div', {class: 'copied'}, h('label', {for: id}, label), box,
    button('Copy', copy), copied);
}
